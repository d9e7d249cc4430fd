/** Speech as a stream over data channels: frames, messages and credit of one speech. Pure. */

/** Bytes of a frame at most, and those of its head. */
const FRAME_LIMIT = 4096;
const HEAD = 8;
/** Samples of one frame at most. */
export const FRAME_SAMPLES = (FRAME_LIMIT - HEAD) / 2;
/** Seconds of sound that may be sent before any credit has come. */
const AHEAD = 1;

export const SPEECH_RATES = [16_000, 24_000, 48_000] as const;
export type SpeechRate = (typeof SPEECH_RATES)[number];

/** What became of a speech: the seconds of it that were heard, and why it was interrupted; empty for not at all. */
export interface Spoken {
  readonly seconds: number;
  readonly reason: string;
}

/** Message of the body about a speech. */
export type SpeechTold =
  | { readonly event: "started"; readonly utterance: number; readonly speech_id: string }
  | {
      readonly event: "credit";
      readonly utterance: number;
      readonly samples: number;
      readonly played: number;
    }
  | { readonly event: "starved"; readonly utterance: number; readonly position: number }
  | {
      readonly event: "finished";
      readonly utterance: number;
      readonly position: number;
      readonly reason?: string;
    }
  | { readonly event: "refused"; readonly utterance: number; readonly reason: string };

const TOLD = ["started", "credit", "starved", "finished", "refused"];

/** Reads a message of the body; null for one of an unknown kind. */
export function readSpeechTold(text: unknown): SpeechTold | null {
  try {
    const told = JSON.parse(String(text)) as SpeechTold;
    return TOLD.includes(told.event) && Number.isInteger(told.utterance) ? told : null;
  } catch {
    return null;
  }
}

/** Returns a frame: utterance and sequence, big endian, then samples, little endian. */
export function packFrame(utterance: number, sequence: number, samples: Int16Array): ArrayBuffer {
  const frame = new DataView(new ArrayBuffer(HEAD + 2 * samples.length));
  frame.setUint32(0, utterance);
  frame.setUint32(4, sequence);
  samples.forEach((sample, index) => frame.setInt16(HEAD + 2 * index, sample, true));
  return frame.buffer;
}

/** Returns samples as they are sent; floats are from -1 to 1, as those of Web Audio. */
export function pcm16(samples: Int16Array | Float32Array): Int16Array {
  if (samples instanceof Int16Array) return samples;
  return Int16Array.from(samples, (sample) => Math.round(Math.max(-1, Math.min(1, sample)) * 32_767));
}

/** Credit at this end: how many samples may be sent. */
export class Credit {
  sent = 0;
  played = 0;
  #granted: number;

  constructor(rate: SpeechRate) {
    this.#granted = AHEAD * rate;
  }

  get room(): number {
    return this.#granted - this.sent;
  }

  grant(samples: number, played: number): void {
    this.#granted = Math.max(this.#granted, samples);
    this.played = Math.max(this.played, played);
  }
}
