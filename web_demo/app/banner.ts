/** The strip that says what is wrong. */

import { byRole, byTestId, setText } from "./dom.ts";
import { secondsUntil } from "./format.ts";
import type { Trouble } from "./trouble.ts";

export class Banner {
  readonly #element = byTestId("banner", HTMLElement);
  readonly #title = byRole("banner-title", HTMLElement);
  readonly #text = byRole("banner-text", HTMLElement);
  readonly #wait = byRole("banner-wait", HTMLElement);
  readonly #action = byTestId("banner-action", HTMLButtonElement);

  constructor(onTryNow: () => void) {
    this.#action.addEventListener("click", onTryNow);
  }

  render(trouble: Trouble | null): void {
    this.#element.hidden = trouble === null;
    this.#element.dataset["kind"] = trouble?.kind ?? "";
    setText(this.#title, trouble?.title ?? "");
    setText(this.#text, trouble?.text ?? "");
    const { retryAt } = trouble ?? {};
    this.#action.hidden = retryAt === undefined;
    // Outside the alert's words: a countdown that is read aloud every second is a nuisance.
    const seconds = retryAt === undefined ? 0 : secondsUntil(retryAt, Date.now());
    const wait = seconds === 0 ? "Trying now" : `Trying again in ${seconds} s`;
    this.#wait.setAttribute("aria-hidden", "true");
    setText(this.#wait, retryAt === undefined ? "" : wait);
  }
}
