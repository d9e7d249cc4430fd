/** Words about what has happened, which go away when they are old. */

import { setText } from "./elements.ts";

/** Milliseconds for which they stand. */
const READABLE = 10_000;

export class PassingText {
  readonly #element: HTMLElement;
  readonly #onGone: () => void;
  #fading: ReturnType<typeof setTimeout> | undefined;

  constructor(element: HTMLElement, onGone: () => void = () => undefined) {
    this.#element = element;
    this.#onGone = onGone;
  }

  /** @param passing whether the words go away by themselves; else they stand until others come */
  show(text: string, passing: boolean): void {
    clearTimeout(this.#fading);
    setText(this.#element, text);
    if (!passing || text === "") return;
    this.#fading = setTimeout(() => {
      setText(this.#element, "");
      this.#onGone();
    }, READABLE);
  }
}
