/** Silence at once: what a browser still holds of a sound that was cut off is not heard. */

/** Milliseconds beyond what is buffered: the fade at the other end, and what is decoded already. */
const MARGIN = 60;
/** Milliseconds that are counted where nothing is known of the buffer. */
const UNKNOWN = 200;
/** No sound is held back for longer, in milliseconds. */
const LONGEST = 1500;

/** The part of a track that is needed. */
export type Silenced = Pick<MediaStreamTrack, "enabled">;

/** Switches the track of one stream off for as long as its buffer has something of what was cut off. */
export class Hush {
  #track: Silenced | null = null;
  #number = 0;

  /**
   * @param track what sounds now
   * @param delay tells the milliseconds from the arrival of a sound to its being heard; null while nobody knows
   * @param cut resolves when the other end has cut it off and what was under way has arrived; how it ends is all the same
   */
  async begin(track: Silenced, delay: () => number | null, cut: Promise<unknown>): Promise<void> {
    const number = ++this.#number;
    if (this.#track !== track) this.end();
    this.#track = track;
    track.enabled = false;
    await Promise.race([cut.catch(() => undefined), passed(LONGEST)]);
    await passed(Math.min((delay() ?? UNKNOWN) + MARGIN, LONGEST));
    if (number === this.#number) this.end();
  }

  /** Lets the track be heard again. */
  end(): void {
    if (this.#track) this.#track.enabled = true;
    this.#track = null;
  }
}

const passed = (milliseconds: number): Promise<void> =>
  new Promise((resolve) => setTimeout(resolve, milliseconds));
