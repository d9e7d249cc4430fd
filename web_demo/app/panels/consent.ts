/** What may be done with microphone and camera: chosen before they are sent, shown and withdrawn while they are. */

import type { Purpose } from "../../sdk/index.ts";
import { AT_FIRST, NOTHING_CHOSEN, PURPOSE_WORDS, consentWords } from "../model/consent.ts";
import { make, setText } from "../dom/elements.ts";

export class ConsentPanel {
  readonly element: HTMLElement;
  readonly #boxes = new Map<Purpose, HTMLInputElement>();
  readonly #strip: HTMLElement;
  readonly #words = make("span", { "data-testid": "consent-words" });
  readonly #withdraw = make(
    "button",
    { type: "button", class: "button small", "data-testid": "consent-withdraw" },
    "Withdraw",
  );
  #sending = false;

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
        this.#render();
        onChange();
      });
      this.#boxes.set(purpose, box);
      return make("label", { class: "consent-row" }, box, words);
    });
    this.#withdraw.addEventListener("click", () => {
      for (const box of this.#boxes.values()) box.checked = false;
      this.#render();
      withdraw();
    });
    this.#strip = make("p", { class: "consent-strip", role: "status" }, this.#words, this.#withdraw);
    const legend = make("legend", {}, "What may be done with microphone and camera");
    this.element = make(
      "div",
      { class: "consent" },
      this.#strip,
      make("fieldset", { class: "consent-rows" }, legend, ...rows),
    );
    this.#render();
  }

  /** Consents to more, as the boxes then show. */
  add(purposes: readonly Purpose[]): void {
    for (const purpose of purposes) {
      const box = this.#boxes.get(purpose);
      if (box) box.checked = true;
    }
    this.#render();
  }

  /** All that is consented to. */
  get purposes(): Purpose[] {
    return [...this.#boxes].filter(([, box]) => box.checked).map(([purpose]) => purpose);
  }

  /** Whether something is sent, so that what holds is shown and can be withdrawn. */
  set sending(sending: boolean) {
    this.#sending = sending;
    this.#render();
  }

  /** Says what holds while something is sent; and where nothing can be sent, why. */
  #render(): void {
    const { purposes } = this;
    this.#strip.hidden = !this.#sending && purposes.length > 0;
    this.#withdraw.hidden = !this.#sending;
    setText(this.#words, this.#sending ? consentWords(purposes) : `${NOTHING_CHOSEN}.`);
  }
}
