/** How loud sound is. Pure. */

export interface Level {
  /** Root mean square and greatest value, in dB of full scale: 0 is as loud as it gets. */
  readonly rms: number;
  readonly peak: number;
}

export const SILENCE: Level = { rms: -100, peak: -100 };

/** What is quieter than this, in dB of full scale, is shown as nothing. */
const QUIETEST = -60;

/** Returns the level of samples from -1 to 1. */
export function levelOf(samples: Float32Array): Level {
  let squares = 0;
  let greatest = 0;
  for (const sample of samples) {
    squares += sample * sample;
    greatest = Math.max(greatest, Math.abs(sample));
  }
  return { rms: decibels(Math.sqrt(squares / samples.length)), peak: decibels(greatest) };
}

/** Returns how much of a bar a level fills, from 0 to 1: as the ear hears it, in equal steps of dB. */
export function filled(db: number): number {
  return Math.min(1, Math.max(0, 1 - db / QUIETEST));
}

/** Returns the level in words; a number that changes all the time says less where it is read aloud. */
export function spoken({ rms, peak }: Level): string {
  if (peak >= -1) return "too loud";
  if (rms >= -30) return "loud";
  return rms >= -50 ? "quiet" : "silent";
}

function decibels(value: number): number {
  return value > 0 ? Math.max(SILENCE.rms, 20 * Math.log10(value)) : SILENCE.rms;
}
