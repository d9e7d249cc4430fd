/** Measurements of picture and sound, once a second, for the panels. */

import { RecentMedian, wallNow } from "../../sdk/media/index.ts";
import type { ClockOffset, Figures, PresentedFrame, RemoteStream } from "../../sdk/media/index.ts";

/** A picture that is older than this stands still: more than any frame rate worth looking at explains. */
export const STILL_AFTER = 200;

/** For how long a picture stood still. Pure: the time is an argument, in milliseconds of a monotonic clock. */
export class Freezes {
  #lastFrame: number | null = null;
  #counted = 0;
  #total = 0;

  frame(now: number): void {
    this.#count(now);
    this.#lastFrame = now;
    this.#counted = now;
  }

  /** Nothing is to be seen, or nothing is to move: what comes next is no end of a freeze. */
  pause(): void {
    this.#lastFrame = null;
  }

  /** Returns for how many milliseconds the picture stood still since the last call. */
  collectFrozen(now: number): number {
    this.#count(now);
    const total = this.#total;
    this.#total = 0;
    return total;
  }

  #count(now: number): void {
    if (this.#lastFrame === null) return;
    // The first moments of a gap are no freeze, in whichever second it began.
    const from = Math.max(this.#counted, this.#lastFrame + STILL_AFTER);
    if (now <= from) return;
    this.#total += now - from;
    this.#counted = now;
  }
}

/** One second. What is not known is null. */
export interface Reading {
  /** Frames shown per second. */
  readonly rate: number | null;
  /** Milliseconds from the camera to this screen. */
  readonly latency: number | null;
  /** Milliseconds of the second for which the picture stood still although it should move. */
  readonly frozen: number | null;
  readonly video: Figures | null;
  readonly audio: Figures | null;
}

/** Figures that are older than this, in milliseconds, are not shown: they come once a second. */
const FRESH = 2500;

/** Milliseconds; a picture that seems to be older came before the track was another one, whose timestamps begin elsewhere. */
const IMPLAUSIBLE = 60_000;

/** The newest figures of one stream. */
class Newest {
  #figures: Figures | null = null;
  #at = 0;
  #stopListening: (() => void) | null = null;

  watch(stream: RemoteStream | null): void {
    this.#stopListening?.();
    this.#figures = null;
    this.#stopListening =
      stream?.on("figures", (figures) => {
        this.#figures = figures;
        this.#at = performance.now();
      }) ?? null;
  }

  at(now: number): Figures | null {
    return now - this.#at < FRESH ? this.#figures : null;
  }
}

export class Readings {
  readonly #listeners: ((reading: Reading) => void)[] = [];
  readonly #latencies = new RecentMedian(2000);
  readonly #freezes = new Freezes();
  readonly #video = new Newest();
  readonly #audio = new Newest();
  #stream: RemoteStream | null = null;
  #clock: ClockOffset | null = null;
  #presented = 0;
  #presentedAt = performance.now();

  constructor() {
    setInterval(() => this.#read(), 1000);
  }

  /** Milliseconds from the camera to this screen, median of the last two seconds; null when unknown. */
  get latency(): number | null {
    return this.#clock === null ? null : this.#latencies.value(performance.now());
  }

  /** How far the engine's clock is ahead; null when it is not known, and with it the latency. */
  get clock(): ClockOffset | null {
    return this.#clock;
  }

  set clock(clock: ClockOffset | null) {
    this.#clock = clock;
  }

  onReading(listener: (reading: Reading) => void): void {
    this.#listeners.push(listener);
  }

  watch(video: RemoteStream | null, audio: RemoteStream | null): void {
    this.#stream = video;
    this.#video.watch(video);
    this.#audio.watch(audio);
  }

  frameShown({ visibleAt, rtpTimestamp }: PresentedFrame): void {
    const now = performance.now();
    this.#presented += 1;
    this.#freezes.frame(now);
    const capturedAt = rtpTimestamp === null ? null : (this.#stream?.capturedAt(rtpTimestamp) ?? null);
    if (capturedAt === null || this.#clock === null) return;
    const latency = wallNow() + visibleAt - now - (capturedAt - this.#clock.offset);
    if (Math.abs(latency) < IMPLAUSIBLE) this.#latencies.push(now, latency);
  }

  #read(): void {
    const now = performance.now();
    const rate = (1000 * this.#presented) / (now - this.#presentedAt);
    this.#presented = 0;
    this.#presentedAt = now;
    const frozen = this.#freezes.collectFrozen(now);
    // What cannot be seen, or is not wanted to move, is not frozen.
    const moving = this.#stream?.desire === "running" && document.visibilityState === "visible";
    if (!moving) this.#freezes.pause();
    const received = this.#video.at(now);
    const video = received && received.width > 0 ? received : null;
    const reading: Reading = {
      rate: video && rate,
      latency: this.latency,
      frozen: moving && video ? frozen : null,
      video,
      audio: this.#audio.at(now),
    };
    for (const listener of this.#listeners) listener(reading);
  }
}
