/** Push to talk: the microphone is sent while a button is held, and what is on its way is heard to its end. */

/** Milliseconds of silence that are sent after the button, so that the last word is recognised. */
export const AFTER = 2000;

/** The microphone, as far as talking needs it. */
export interface Talked {
  /** Whether it is on, or about to be. */
  readonly isOn: boolean;
  toggle(): Promise<void>;
  off(): Promise<void>;
}

export interface Microphone {
  readonly control: Talked;
  readonly stream: { muted: boolean };
}

export class Talking {
  readonly #microphone: () => Microphone | null;
  readonly #onChange: () => void;
  #held = false;
  /** What is on by the button alone; null where nothing is. What is on by its own switch is not touched. */
  #begun: Microphone | null = null;
  #ending: ReturnType<typeof setTimeout> | undefined;

  /**
   * @param microphone returns it; null where the body takes none
   * @param onChange is called when it is held, let go, or over
   */
  constructor(microphone: () => Microphone | null, onChange: () => void) {
    this.#microphone = microphone;
    this.#onChange = onChange;
  }

  get held(): boolean {
    return this.#held;
  }

  /** Whether it is held, or what was said while it was is on its way. */
  get talks(): boolean {
    return this.#held || this.#begun !== null;
  }

  press(): void {
    const microphone = this.#microphone();
    if (this.#held || microphone === null) return;
    this.#held = true;
    clearTimeout(this.#ending);
    // Switched off by its own button meanwhile, it is begun anew.
    if (!microphone.control.isOn) {
      this.#begun = microphone;
      void microphone.control.toggle();
    }
    if (this.#begun) this.#begun.stream.muted = false;
    this.#onChange();
  }

  /** Lets go: nothing but silence is sent from now on, and then nothing. */
  release(): void {
    if (!this.#held) return;
    this.#held = false;
    if (this.#begun) {
      this.#begun.stream.muted = true;
      this.#ending = setTimeout(() => this.end(), AFTER);
    }
    this.#onChange();
  }

  /** Switches off at once what the button has switched on. */
  end(): void {
    const talked = this.talks;
    this.#held = false;
    clearTimeout(this.#ending);
    const begun = this.#begun;
    this.#begun = null;
    if (begun) {
      begun.stream.muted = true;
      void begun.control.off().finally(() => {
        if (this.#begun === null) begun.stream.muted = false;
      });
    }
    if (talked) this.#onChange();
  }
}
