/** For how long a picture stood still. Pure: the time is an argument, in milliseconds of a monotonic clock. */

/** A picture that is older than this stands still: more than any frame rate worth looking at explains. */
export const STILL_AFTER = 200;

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
  take(now: number): number {
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
