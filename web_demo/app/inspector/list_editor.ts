/** A list, edited item by item. */

import { make, setText } from "../dom/elements.ts";
import { arrange, button, iconButton } from "./controls.ts";
import { fieldKind, itemType, listItems, listText, misfit } from "./value_text.ts";

interface Item {
  readonly element: HTMLElement;
  readonly input: HTMLInputElement;
  readonly problem: HTMLElement;
}

export class ListEditor {
  readonly element: HTMLElement;
  readonly #code: string;
  readonly #type: string;
  readonly #onChange: () => void;
  readonly #list = make("ol", { class: "list-items" });
  readonly #add: HTMLButtonElement;
  #items: Item[] = [];
  /** Without items the list is empty, or there is none. */
  #none = true;

  constructor(code: string, id: string, onChange: () => void) {
    this.#code = code;
    this.#type = itemType(code);
    this.#onChange = onChange;
    this.#add = button("Add item", () => this.#insert(this.#items.length));
    const attributes = { class: "list-editor", role: "group", "aria-labelledby": `${id}-label` };
    this.element = make("div", attributes, this.#list, this.#add);
  }

  get text(): string {
    if (this.#items.length === 0 && this.#none) return "";
    return listText(
      this.#code,
      this.#items.map(({ input }) => input.value),
    );
  }

  set text(text: string) {
    const items = listItems(text);
    this.#none = items === null;
    this.#items = (items ?? []).map((item) => this.#item(item));
    this.#render();
  }

  focus(): void {
    (this.#items.find(({ problem }) => problem.textContent !== "")?.input ?? this.#add).focus();
  }

  #item(text: string): Item {
    const modes: Record<string, string> = { integer: "numeric", number: "decimal" };
    const inputmode = modes[fieldKind(this.#type)] ?? "text";
    const input = make("input", { type: "text", inputmode, spellcheck: "false", autocomplete: "off" });
    input.value = text;
    const problem = make("p", { class: "problem", "aria-live": "polite" });
    const remove = iconButton("remove", "Remove this item", () => this.#remove(item));
    const item = {
      element: make("li", {}, make("div", { class: "joined" }, input, remove), problem),
      input,
      problem,
    };
    input.addEventListener("input", () => this.#changed());
    input.addEventListener("keydown", (event) => this.#key(event, item));
    return item;
  }

  /** Enter goes to the next item and makes one at the end; Backspace takes an empty item away. */
  #key(event: KeyboardEvent, item: Item): void {
    const index = this.#items.indexOf(item);
    if (
      event.key === "Enter" &&
      !event.isComposing &&
      !event.ctrlKey &&
      !event.metaKey &&
      item.input.value !== ""
    ) {
      event.preventDefault();
      const next = this.#items[index + 1];
      if (next) next.input.focus();
      else this.#insert(index + 1);
    } else if (event.key === "Backspace" && item.input.value === "") {
      event.preventDefault();
      this.#remove(item);
    }
  }

  #insert(index: number): void {
    const item = this.#item("");
    this.#none = false;
    this.#items.splice(index, 0, item);
    this.#changed();
    item.input.focus();
  }

  #remove(item: Item): void {
    const index = this.#items.indexOf(item);
    this.#items.splice(index, 1);
    this.#changed();
    (this.#items[Math.max(0, index - 1)]?.input ?? this.#add).focus();
  }

  #changed(): void {
    this.#render();
    this.#onChange();
  }

  #render(): void {
    this.#list.hidden = this.#items.length === 0;
    arrange(
      this.#list,
      this.#items.map(({ element }) => element),
    );
    this.#items.forEach(({ input, problem }, index) => {
      input.setAttribute("aria-label", `Item ${index + 1}`);
      const wrong = misfit(this.#type, input.value) ?? "";
      setText(problem, wrong);
      input.classList.toggle("invalid", wrong !== "");
    });
  }
}
