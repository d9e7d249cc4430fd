/** A switch with its words. */

import { make } from "../dom/elements.ts";

export class Switch {
  readonly element: HTMLButtonElement;
  readonly #onChange: (on: boolean) => void;

  /** @param name by which tests know it */
  constructor(name: string, words: string, onChange: (on: boolean) => void) {
    this.#onChange = onChange;
    this.element = make(
      "button",
      { type: "button", class: "switch", role: "switch", "aria-checked": "false", "data-testid": name },
      make("span", { class: "switch-words" }, words),
      make("span", { class: "switch-track", "aria-hidden": "true" }),
    );
    this.element.addEventListener("click", () => {
      this.on = !this.on;
      this.#onChange(this.on);
    });
  }

  get on(): boolean {
    return this.element.getAttribute("aria-checked") === "true";
  }

  set on(on: boolean) {
    this.element.setAttribute("aria-checked", String(on));
  }
}
