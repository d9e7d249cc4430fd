/** Figures of a stream, computed from the browser's counters. Pure. */

/** Counters at one moment. All of them only grow, except the size and the round trip. */
export interface Sample {
  /** Milliseconds of a monotonic clock. */
  readonly at: number;
  readonly bytes: number;
  readonly packets: number;
  readonly packetsLost: number;
  /** Video frames decoded or sent, or audio packets received or sent. */
  readonly units: number;
  readonly dropped: number;
  /** Seconds that all units together spent in the jitter buffer. */
  readonly bufferDelay: number;
  readonly bufferCount: number;
  /** Seconds that all samples together waited for the sound device, and how many these are; 0 where unknown. */
  readonly deviceDelay: number;
  readonly deviceCount: number;
  /** Seconds for which the picture stood still, all together, as the browser judges it. */
  readonly frozen: number;
  /** MIME type; empty while it is not known. */
  readonly codec: string;
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
  /** The part of the interval's packets that was lost and not sent again in time, from 0 to 1. */
  readonly loss: number;
  /** Milliseconds of the interval for which the picture stood still. */
  readonly frozen: number;
  /** MIME type, such as `video/H264`; empty while it is not known. */
  readonly codec: string;
  /** Milliseconds in the jitter buffer, mean of the interval; null when nothing left it. */
  readonly bufferDelay: number | null;
  /** Milliseconds from there to the ear, mean of the interval; null for pictures, and where the browser does not say. */
  readonly deviceDelay: number | null;
}

/** Returns what happened between two samples; null when they do not belong together. */
export function figuresBetween(before: Sample, after: Sample): Figures | null {
  const seconds = (after.at - before.at) / 1000;
  if (seconds <= 0 || after.bytes < before.bytes || after.units < before.units) return null;
  // A packet that comes after all takes back its loss.
  const lost = Math.max(0, after.packetsLost - before.packetsLost);
  const expected = after.packets - before.packets + lost;
  return {
    rate: (after.units - before.units) / seconds,
    bitrate: (8 * (after.bytes - before.bytes)) / seconds,
    width: after.width,
    height: after.height,
    roundTrip: after.roundTrip,
    dropped: after.dropped,
    packetsLost: after.packetsLost,
    loss: expected > 0 ? lost / expected : 0,
    frozen: Math.max(0, 1000 * (after.frozen - before.frozen)),
    codec: after.codec,
    bufferDelay: mean(after.bufferDelay - before.bufferDelay, after.bufferCount - before.bufferCount),
    deviceDelay: mean(after.deviceDelay - before.deviceDelay, after.deviceCount - before.deviceCount),
  };
}

/** Milliseconds of each. */
function mean(seconds: number, count: number): number | null {
  return count > 0 ? (1000 * seconds) / count : null;
}

type Report = Record<string, unknown> & { readonly type: string };

/** Reads a sample out of what a receiver or a sender counts; null while nothing is received or sent. */
export function readSample(reports: Iterable<Report>, at: number): Sample | null {
  const found = new Map<string, Report>();
  const codecs = new Map<unknown, Report>();
  let roundTrip: number | null = null;
  for (const report of reports) {
    found.set(report.type, report);
    if (report.type === "codec") codecs.set(report["id"], report);
    if (report.type === "candidate-pair" && report["nominated"] === true && report["state"] === "succeeded") {
      const seconds = report["currentRoundTripTime"];
      if (typeof seconds === "number") roundTrip = seconds * 1000;
    }
  }
  const inbound = found.get("inbound-rtp");
  const flow = inbound ?? found.get("outbound-rtp");
  if (!flow) return null;
  const video = flow["kind"] === "video";
  const either = (received: string, sent: string): number => count(flow, inbound ? received : sent);
  const codec = codecs.get(flow["codecId"])?.["mimeType"];
  return {
    at,
    bytes: either("bytesReceived", "bytesSent"),
    packets: either("packetsReceived", "packetsSent"),
    // How much of what was sent is lost, only the other end knows.
    packetsLost: count(inbound ?? found.get("remote-inbound-rtp"), "packetsLost"),
    units: video ? either("framesDecoded", "framesSent") : either("packetsReceived", "packetsSent"),
    dropped: count(flow, "framesDropped"),
    bufferDelay: count(flow, "jitterBufferDelay"),
    bufferCount: count(flow, "jitterBufferEmittedCount"),
    deviceDelay: count(found.get("media-playout"), "totalPlayoutDelay"),
    deviceCount: count(found.get("media-playout"), "totalSamplesCount"),
    frozen: count(flow, "totalFreezesDuration"),
    codec: typeof codec === "string" ? codec : "",
    width: count(flow, "frameWidth"),
    height: count(flow, "frameHeight"),
    roundTrip,
  };
}

function count(report: Report | undefined, name: string): number {
  const value = report?.[name];
  return typeof value === "number" ? value : 0;
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
