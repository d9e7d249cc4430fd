/** Card with the parts of the body: which application has each of them, and for how long. */

import { byTestId, make, setText } from "../dom/elements.ts";
import type { BodyControl } from "../model/body_control.ts";
import type { BodyPart } from "../model/part_leases.ts";
import { amid, named, sentence } from "../model/plain_words.ts";

/** One line of the list. */
interface Row {
  readonly item: HTMLElement;
  readonly words: HTMLElement;
  readonly button: HTMLButtonElement;
  part: BodyPart;
}

export class PartsPanel {
  readonly #body: BodyControl;
  readonly #card = byTestId("parts", HTMLElement);
  readonly #list = byTestId("part-rows", HTMLElement);
  readonly #rows = new Map<string, Row>();
  #mayOperate = true;

  constructor(body: BodyControl) {
    this.#body = body;
  }

  /** Whether the visitor may operate; else the list has no buttons. */
  set mayOperate(mayOperate: boolean) {
    this.#mayOperate = mayOperate;
    this.render();
  }

  /** Shows how things stand now; the seconds go on. */
  render(): void {
    const { parts } = this.#body;
    this.#card.hidden = parts.length === 0;
    const names = parts.map(({ name }) => name);
    if (names.join() !== [...this.#rows.keys()].join()) {
      this.#rows.clear();
      for (const part of parts) this.#rows.set(part.name, this.#make(part));
      this.#list.replaceChildren(...[...this.#rows.values()].map(({ item }) => item));
    }
    for (const part of parts) {
      const row = this.#rows.get(part.name);
      if (row) this.#update(row, part);
    }
  }

  #make(part: BodyPart): Row {
    const words = make("span", { class: "part-holder" });
    const button = make("button", { type: "button", class: "button small" });
    const name = make("span", { class: "part-name" }, sentence(part.name.replaceAll("_", " ")));
    const row: Row = {
      item: make("li", { "data-part": part.name }, name, words, button),
      words,
      button,
      part,
    };
    button.addEventListener("click", () => void this.#press(row.part));
    return row;
  }

  #update(row: Row, part: BodyPart): void {
    row.part = part;
    row.item.dataset["state"] = part.state;
    setText(row.words, holderWords(part));
    const action = this.#actionOf(part);
    row.button.hidden = action === "";
    setText(row.button, action);
    row.button.setAttribute("aria-label", `${action}: ${part.name}`);
  }

  #actionOf(part: BodyPart): string {
    if (!this.#mayOperate) return "";
    if (this.#body.isTakenOver(part)) return "Hand back";
    return this.#body.mayTakeOver(part) ? "Take over" : "";
  }

  async #press(part: BodyPart): Promise<void> {
    const isBack = this.#body.isTakenOver(part);
    // A refusal is shown by the button's end: the holder does not rank lower.
    await (isBack ? this.#body.handBackPart(part) : this.#body.takePart(part)).catch(() => undefined);
    this.render();
  }
}

/** Says of a part which application has it, from which, and for how long: `ann, from night watch, 18 s left`. */
export function holderWords({ state, holder, absent, lender, seconds }: BodyPart): string {
  if (state === "free") return "free";
  const holds = state === "mine" ? "yours" : `${named(holder)}${absent ? ", connection lost" : ""}`;
  return lender === "" ? holds : `${holds}, from ${amid(named(lender))}, ${seconds} s left`;
}
