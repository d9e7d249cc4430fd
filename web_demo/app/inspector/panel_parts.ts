/** What the panels of components and engines are made of. */

import { make } from "../dom/elements.ts";
import { copyButton, showCount } from "./controls.ts";
import { faultRow } from "./fault_log.ts";
import type { Fault } from "./fault_log.ts";
import { drawing } from "./icons.ts";
import type { IconName } from "./icons.ts";

/** A card with a title, how many things are in it, and the things. */
export class Group {
  readonly element: HTMLElement;
  readonly body = make("div", { class: "group-body" });
  /** Leads to the group from the top of the panel. */
  readonly jump: HTMLButtonElement;
  readonly #counts: HTMLElement[];

  constructor(kind: string, title: string, icon: IconName, note = "") {
    this.#counts = [make("span", { class: "count" }), make("span", { class: "count" })];
    const [inTitle = "", inJump = ""] = this.#counts;
    const hint = make("p", { class: "hint" }, note);
    const head = make("header", {}, make("h3", {}, drawing(icon), title, inTitle), hint);
    this.element = make(
      "section",
      { class: "card group", "data-group": kind, "aria-label": title },
      head,
      this.body,
    );
    this.jump = make("button", { type: "button", class: "jump" }, drawing(icon), title, inJump);
    this.jump.addEventListener("click", () => this.element.scrollIntoView({ behavior: "smooth" }));
    this.count = 0;
  }

  set count(count: number) {
    for (const each of this.#counts) showCount(each, count);
  }

  set shown(shown: boolean) {
    this.element.hidden = !shown;
    this.jump.hidden = !shown;
  }
}

/** A name or reference that can be copied. */
export function copyable(label: string, text: string): HTMLElement {
  return make(
    "div",
    { class: "copyable" },
    make("dt", {}, label),
    make(
      "dd",
      {},
      make("code", {}, text),
      copyButton(`Copy ${label.toLowerCase()}`, () => text),
    ),
  );
}

/** The errors of a component or engine; the group is not there while there are none. */
export class FaultGroup extends Group {
  readonly #rows = new Map<Fault, { detail: Fault["detail"]; row: HTMLElement }>();
  readonly #list = make("ol", { class: "heard faults" });

  constructor() {
    super("errors", "Errors", "error");
    this.body.append(this.#list);
    this.show([]);
  }

  show(faults: readonly Fault[]): void {
    this.shown = faults.length > 0;
    this.count = faults.length;
    const rows = faults.map((fault) => this.#row(fault));
    for (const fault of this.#rows.keys()) if (!faults.includes(fault)) this.#rows.delete(fault);
    this.#list.replaceChildren(...rows);
  }

  /** A row that was opened stays open; it is made anew when more is known. */
  #row(fault: Fault): HTMLElement {
    const known = this.#rows.get(fault);
    if (known && known.detail === fault.detail) return known.row;
    const row = faultRow(fault);
    if (known?.row.querySelector("details[open]")) row.querySelector("details")?.setAttribute("open", "");
    this.#rows.set(fault, { detail: fault.detail, row });
    return row;
  }
}
