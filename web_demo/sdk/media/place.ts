/** Where a stream is carried. */

import type { Emitter } from "../jsonrpc/events.ts";
import type { MediaPeer } from "./peer.ts";
import { figuresBetween } from "./statistics.ts";
import type { Sample } from "./statistics.ts";
import type { StreamEvents } from "./stream.ts";

/** A section of one of the peer connections. */
export interface Attachment {
  readonly peer: MediaPeer;
  readonly transceiver: RTCRtpTransceiver;
}

/** Where a stream is carried now, and where it will be once the first frame has come, or gone, there. */
export class StreamPlace {
  /** Media flows. */
  onFlow: () => void = () => undefined;
  /** There is another place, beside the one so far or instead of it. */
  onAttached: (attachment: Attachment) => void = () => undefined;
  readonly #events: Emitter<StreamEvents>;
  readonly #receives: boolean;
  #current: Attachment | null = null;
  #next: Attachment | null = null;
  #sample: Sample | null = null;
  #located = false;
  #playoutDelay: number | null = null;

  /** @param receives there is a track of the engine's */
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

  /** Milliseconds in the jitter buffer and on the way to the device, as they were last; null while nothing flows. */
  get playoutDelay(): number | null {
    return this.#playoutDelay;
  }

  /** The present connection of the stream has a place; what is shown may still come from the one before. */
  get located(): boolean {
    return this.#located;
  }

  /** Something has arrived at the newest place, or left from there. */
  get flowed(): boolean {
    return this.#located && this.#next === null && this.#sample !== null && this.#sample.units > 0;
  }

  /** The stream is carried here too. It is shown from here at once if it was shown nowhere. */
  attach(attachment: Attachment): void {
    const { newest } = this;
    this.#located = true;
    if (newest?.peer === attachment.peer && newest.transceiver === attachment.transceiver) return;
    this.#next = attachment;
    this.onAttached(attachment);
    if (!this.#current) this.promote();
  }

  /** The first frame has come: the stream is shown from the newest place. */
  promote(): void {
    if (!this.#next) return;
    this.#current = this.#next;
    this.#next = null;
    this.#sample = null;
    if (this.#receives) this.#events.emit("track", this.#current.transceiver.receiver.track);
    this.#events.emit("change", undefined);
  }

  /** A peer connection is about to be closed. */
  detach(peer: MediaPeer): void {
    if (this.#next?.peer === peer) this.#next = null;
    if (this.#current?.peer === peer) this.#interrupt();
    this.promote();
  }

  /** The connection of the stream has ended. What is shown stays. */
  forget(): void {
    this.#next = null;
    this.#located = false;
  }

  /** The stream is not wanted any more. */
  drop(): void {
    this.forget();
    if (this.#current) this.#interrupt();
  }

  /** Counters of the current place. */
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
