/** Figures of a stream, computed from what the browser counts. The computing is pure. */

/** Counters at one moment. All of them only grow, except the size and the round trip. */
export interface Sample {
  /** Milliseconds of a monotonic clock. */
  readonly at: number;
  readonly bytes: number;
  readonly packetsLost: number;
  /** Video frames decoded, or audio packets received. */
  readonly units: number;
  readonly dropped: number;
  /** Seconds that all units together spent in the jitter buffer. */
  readonly bufferDelay: number;
  readonly bufferCount: number;
  readonly width: number;
  readonly height: number;
  /** Milliseconds; null while no path has measured one. */
  readonly roundTrip: number | null;
}

export interface Figures {
  /** Video frames, or audio packets, per second. */
  readonly rate: number;
  /** Bits per second. */
  readonly bitrate: number;
  readonly width: number;
  readonly height: number;
  readonly roundTrip: number | null;
  /** Frames that were decoded, or could not be, and never shown; since the stream began. */
  readonly dropped: number;
  readonly packetsLost: number;
  /** Milliseconds in the jitter buffer, mean of the interval; null when nothing left it. */
  readonly bufferDelay: number | null;
}

/** Returns what happened between two samples; null when they do not belong together. */
export function figuresBetween(before: Sample, after: Sample): Figures | null {
  const seconds = (after.at - before.at) / 1000;
  if (seconds <= 0 || after.bytes < before.bytes || after.units < before.units) return null;
  const left = after.bufferCount - before.bufferCount;
  return {
    rate: (after.units - before.units) / seconds,
    bitrate: (8 * (after.bytes - before.bytes)) / seconds,
    width: after.width,
    height: after.height,
    roundTrip: after.roundTrip,
    dropped: after.dropped,
    packetsLost: after.packetsLost,
    bufferDelay: left > 0 ? (1000 * (after.bufferDelay - before.bufferDelay)) / left : null,
  };
}

type Report = Record<string, unknown> & { readonly type: string };

/** Reads a sample out of `RTCRtpReceiver.getStats()`; null while it has no inbound stream. */
export function readSample(reports: Iterable<Report>, at: number): Sample | null {
  let inbound: Report | undefined;
  let roundTrip: number | null = null;
  for (const report of reports) {
    if (report.type === "inbound-rtp") inbound = report;
    if (report.type === "candidate-pair" && report["nominated"] === true && report["state"] === "succeeded") {
      const seconds = report["currentRoundTripTime"];
      if (typeof seconds === "number") roundTrip = seconds * 1000;
    }
  }
  if (!inbound) return null;
  const count = (name: string): number => {
    const value = inbound[name];
    return typeof value === "number" ? value : 0;
  };
  return {
    at,
    bytes: count("bytesReceived"),
    packetsLost: count("packetsLost"),
    units: inbound["kind"] === "video" ? count("framesDecoded") : count("packetsReceived"),
    dropped: count("framesDropped"),
    bufferDelay: count("jitterBufferDelay"),
    bufferCount: count("jitterBufferEmittedCount"),
    width: count("frameWidth"),
    height: count("frameHeight"),
    roundTrip,
  };
}

/** The median of the numbers that were pushed within the last `span` milliseconds, and how many these are. */
export class RecentMedian {
  readonly #span: number;
  readonly #limit: number;
  #entries: { at: number; value: number }[] = [];

  constructor(span: number, limit = 256) {
    this.#span = span;
    this.#limit = limit;
  }

  push(at: number, value: number): void {
    this.#entries.push({ at, value });
    if (this.#entries.length > this.#limit) this.#entries.shift();
  }

  /** Returns null when nothing was pushed lately. */
  value(now: number): number | null {
    this.#entries = this.#entries.filter((entry) => entry.at > now - this.#span);
    const values = this.#entries.map((entry) => entry.value).sort((a, b) => a - b);
    const middle = Math.floor(values.length / 2);
    const upper = values[middle];
    if (upper === undefined) return null;
    return values.length % 2 === 1 ? upper : (upper + (values[middle - 1] ?? upper)) / 2;
  }
}
