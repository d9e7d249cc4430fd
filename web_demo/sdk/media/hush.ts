/** Mutes the rest of interrupted speech that the browser still buffers. */

/** Milliseconds beyond what is buffered: the fade at the other end, and what is decoded already. */
const MARGIN = 60;
/** Milliseconds assumed for an unknown buffer. */
const UNKNOWN = 200;
/** Most milliseconds of silence. */
const LONGEST = 1500;

/** The part of a track that is needed. */
export type Silenced = Pick<MediaStreamTrack, "enabled">;

/** Disables the track of one stream until its buffer has played out what was interrupted. */
export class Hush {
  #track: Silenced | null = null;
  #number = 0;

  /**
   * @param track what sounds now
   * @param delay returns the milliseconds from the arrival of a sound to its playing; null while unknown
   * @param cut resolves when the other end has cut it off and what was under way has arrived; how it ends is all the same
   */
  async begin(track: Silenced, delay: () => number | null, cut: Promise<unknown>): Promise<void> {
    const number = ++this.#number;
    if (this.#track !== track) this.restoreSound();
    this.#track = track;
    track.enabled = false;
    await Promise.race([cut.catch(() => undefined), passed(LONGEST)]);
    await passed(Math.min((delay() ?? UNKNOWN) + MARGIN, LONGEST));
    if (number === this.#number) this.restoreSound();
  }

  /** Enables the track again. */
  restoreSound(): void {
    if (this.#track) this.#track.enabled = true;
    this.#track = null;
  }
}

const passed = (milliseconds: number): Promise<void> =>
  new Promise((resolve) => setTimeout(resolve, milliseconds));
