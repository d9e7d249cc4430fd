/** The section of a peer connection that carries a stream, and its counters. */

import type { Emitter } from "../jsonrpc/events.ts";
import type { MediaPeer } from "./peer.ts";
import { figuresBetween, readSample } from "./statistics.ts";
import type { Sample } from "./statistics.ts";
import type { ControlledStream, StreamEvents } from "./stream.ts";

/** A section of one of the peer connections. */
export interface Attachment {
  readonly peer: MediaPeer;
  readonly transceiver: RTCRtpTransceiver;
}

/** The section that carries a stream now, and the next one, used from its first frame on. */
export class StreamPlace {
  /** Is called when media flows. */
  onFlow: () => void = () => undefined;
  /** Is called for another section, beside the present one or instead of it. */
  onAttached: (attachment: Attachment) => void = () => undefined;
  readonly #events: Emitter<StreamEvents>;
  readonly #receives: boolean;
  #current: Attachment | null = null;
  #next: Attachment | null = null;
  #sample: Sample | null = null;
  #located = false;
  #playoutDelay: number | null = null;

  /** @param receives whether the engine sends a track */
  constructor(events: Emitter<StreamEvents>, receives: boolean) {
    this.#events = events;
    this.#receives = receives;
  }

  get current(): Attachment | null {
    return this.#current;
  }

  get next(): Attachment | null {
    return this.#next;
  }

  get newest(): Attachment | null {
    return this.#next ?? this.#current;
  }

  /** Newest milliseconds in the jitter buffer and output device; null while nothing flows. */
  get playoutDelay(): number | null {
    return this.#playoutDelay;
  }

  /** Whether the stream's present connection has a section; the picture may still come from the former one. */
  get located(): boolean {
    return this.#located;
  }

  /** Whether media has flowed in the newest section. */
  get flowed(): boolean {
    return this.#located && this.#next === null && this.#sample !== null && this.#sample.units > 0;
  }

  /** Adds a section that carries the stream; the first one is shown at once. */
  attach(attachment: Attachment): void {
    const { newest } = this;
    this.#located = true;
    if (newest?.peer === attachment.peer && newest.transceiver === attachment.transceiver) return;
    this.#next = attachment;
    this.onAttached(attachment);
    if (!this.#current) this.promote();
  }

  /** Shows the stream from the newest section, whose first frame has come. */
  promote(): void {
    if (!this.#next) return;
    this.#current = this.#next;
    this.#next = null;
    this.#sample = null;
    if (this.#receives) this.#events.emit("track", this.#current.transceiver.receiver.track);
    this.#events.emit("change", undefined);
  }

  /** Leaves a peer connection that is about to be closed. */
  detach(peer: MediaPeer): void {
    if (this.#next?.peer === peer) this.#next = null;
    if (this.#current?.peer === peer) this.#interrupt();
    this.promote();
  }

  /** Drops the next section, since the stream's connection ended. The picture stays. */
  connectionEnded(): void {
    this.#next = null;
    this.#located = false;
  }

  /** Leaves all sections, since the stream is disconnected. */
  drop(): void {
    this.connectionEnded();
    if (this.#current) this.#interrupt();
  }

  /** Takes counters of the current section. */
  sampled(sample: Sample): void {
    const figures = this.#sample && figuresBetween(this.#sample, sample);
    this.#sample = sample;
    if (!figures) return;
    if (figures.rate > 0) this.onFlow();
    const { bufferDelay, deviceDelay } = figures;
    this.#playoutDelay = bufferDelay === null ? null : bufferDelay + (deviceDelay ?? 0);
    this.#events.emit("figures", figures);
  }

  #interrupt(): void {
    if (this.#receives) this.#events.emit("interrupted", undefined);
    this.#current = null;
    this.#sample = null;
    this.#playoutDelay = null;
    this.#events.emit("change", undefined);
  }
}

/** Returns a counter that grows while media arrives: bytes on a hidden page, which may stop decoding. */
export function progress(sample: Sample | undefined): number {
  if (!sample) return 0;
  return globalThis.document?.visibilityState === "hidden" ? sample.bytes : sample.units;
}

/** Reads the browser's counters of a section; null for a closed or missing one. */
export async function readCounters(
  attachment: Attachment | null,
  { direction }: ControlledStream,
): Promise<Sample | null> {
  if (!attachment || attachment.peer.closed) return null;
  const { sender, receiver } = attachment.transceiver;
  const stats = await (direction === "sendonly" ? sender : receiver).getStats();
  return readSample((stats as unknown as Map<string, never>).values(), performance.now());
}
