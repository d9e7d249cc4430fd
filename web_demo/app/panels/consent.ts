/** What may be done with microphone and camera: chosen before they are sent, shown and withdrawn while they are. */

import type { Purpose } from "../../sdk/index.ts";
import { AT_FIRST, PURPOSE_WORDS, consentWords } from "../model/consent.ts";
import { make, setText } from "../dom/elements.ts";

export class ConsentPanel {
  readonly element: HTMLElement;
  readonly #boxes = new Map<Purpose, HTMLInputElement>();
  readonly #strip: HTMLElement;
  readonly #words = make("span", { "data-testid": "consent-words" });

  /**
   * @param onChange is called when something else is consented to
   * @param withdraw is called when everything is withdrawn
   */
  constructor(onChange: () => void, withdraw: () => void) {
    const purposes = Object.entries(PURPOSE_WORDS) as [Purpose, string][];
    const rows = purposes.map(([purpose, words]) => {
      const box = make("input", { type: "checkbox", "data-testid": `consent-${purpose}` });
      box.checked = AT_FIRST.includes(purpose);
      box.addEventListener("change", () => {
        this.#showWords();
        onChange();
      });
      this.#boxes.set(purpose, box);
      return make("label", { class: "consent-row" }, box, words);
    });
    const button = make(
      "button",
      { type: "button", class: "button", "data-testid": "consent-withdraw" },
      "Withdraw",
    );
    button.addEventListener("click", () => {
      for (const box of this.#boxes.values()) box.checked = false;
      this.#showWords();
      withdraw();
    });
    this.#strip = make("p", { class: "consent-strip", role: "status" }, this.#words, button);
    this.#strip.hidden = true;
    const legend = make("legend", {}, "What may be done with microphone and camera");
    this.element = make(
      "div",
      { class: "consent" },
      this.#strip,
      make("fieldset", { class: "consent-rows" }, legend, ...rows),
    );
    this.#showWords();
  }

  /** All that is consented to. */
  get purposes(): Purpose[] {
    return [...this.#boxes].filter(([, box]) => box.checked).map(([purpose]) => purpose);
  }

  /** Whether something is sent, so that what holds is shown and can be withdrawn. */
  set sending(sending: boolean) {
    this.#strip.hidden = !sending;
  }

  #showWords(): void {
    setText(this.#words, consentWords(this.purposes));
  }
}
