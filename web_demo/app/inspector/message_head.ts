/** The first line of a message's card: its name, what it gives, and what can be done with it. */

import type { JsonObject, ParameterProfile } from "../../sdk/index.ts";
import { make } from "../dom/elements.ts";
import { iconButton, jsonBlock } from "./controls.ts";

/** @param notes what else is to be known of the message, such as its time limit */
export function messageHead(
  name: string,
  results: readonly ParameterProfile[],
  notes: readonly string[],
  ...tools: Node[]
): HTMLElement {
  const gives = results.map(({ name: result, data_type_ref }) =>
    make("span", { class: "gives" }, `${result} `, make("span", { class: "type" }, data_type_ref.code)),
  );
  const more = notes.map((note) => make("span", { class: "hint" }, note));
  const signature = make("p", { class: "signature" }, ...gives, ...more);
  const title = make("h4", {}, name);
  return make(
    "div",
    { class: "message-head" },
    make("div", { class: "message-title" }, title, signature),
    make("div", { class: "tools" }, ...tools),
  );
}

/** Preview of the message that would be sent: a button that shows it, and its element. */
export class RequestPreview {
  readonly toggle: HTMLButtonElement;
  readonly element = make("div", { class: "request", hidden: "" });
  readonly #method: string;
  readonly #params: () => object;

  constructor(method: string, params: () => object) {
    this.#method = method;
    this.#params = params;
    this.toggle = iconButton("braces", "Show the message that is sent", () => {
      this.element.hidden = !this.element.hidden;
      this.toggle.setAttribute("aria-expanded", String(!this.element.hidden));
      this.render();
    });
    this.toggle.setAttribute("aria-expanded", "false");
  }

  /** Shows the message anew. */
  render(): void {
    if (this.element.hidden) return;
    const message = { jsonrpc: "2.0", id: 1, method: this.#method, params: this.#params() as JsonObject };
    this.element.replaceChildren(jsonBlock(message, "The message that is sent"));
  }
}
