/** Banner with the present trouble. */

import { byRole, byTestId, setText } from "../dom/elements.ts";
import { secondsUntil } from "../model/format.ts";
import type { Trouble } from "../model/trouble.ts";

export class Banner {
  readonly #element = byTestId("banner", HTMLElement);
  readonly #title = byRole("banner-title", HTMLElement);
  readonly #text = byRole("banner-text", HTMLElement);
  readonly #wait = byRole("banner-wait", HTMLElement);
  readonly #action = byTestId("banner-action", HTMLButtonElement);

  readonly #form = byTestId("token-form", HTMLFormElement);
  readonly #token = byTestId("token", HTMLInputElement);

  /** @param onToken takes what was pasted; returns false where it is no token */
  constructor(onTryNow: () => void, onToken: (text: string) => boolean) {
    this.#action.addEventListener("click", onTryNow);
    this.#token.addEventListener("input", () => this.#token.setCustomValidity(""));
    this.#form.addEventListener("submit", (event) => {
      event.preventDefault();
      if (onToken(this.#token.value)) return void (this.#token.value = "");
      this.#token.setCustomValidity(
        "This is not a token. A token has three parts with points between them: paste the whole of it.",
      );
      this.#token.reportValidity();
    });
  }

  render(trouble: Trouble | null): void {
    this.#element.hidden = trouble === null;
    this.#element.dataset["kind"] = trouble?.kind ?? "";
    setText(this.#title, trouble?.title ?? "");
    setText(this.#text, trouble?.text ?? "");
    this.#form.hidden = trouble?.kind !== "no-token";
    const { retryAt } = trouble ?? {};
    this.#action.hidden = retryAt === undefined;
    // Outside the alert's words: a countdown that is read aloud every second is a nuisance.
    const seconds = retryAt === undefined ? 0 : secondsUntil(retryAt, Date.now());
    const wait = seconds === 0 ? "Trying now" : `Trying again in ${seconds} s`;
    this.#wait.setAttribute("aria-hidden", "true");
    setText(this.#wait, retryAt === undefined ? "" : wait);
  }
}
