/** The tree of engines and components: searched, opened and closed, and walked through with the keyboard. */

import type { ComponentStatus } from "../../sdk/index.ts";
import { make, setText } from "../dom/elements.ts";
import { codeWords } from "../model/code_words.ts";
import { arrange, button } from "./controls.ts";
import { drawing } from "./icons.ts";
import { componentsOf, statusQuery, visibleRows } from "./profile_tree.ts";
import type { ComponentNode, EngineNode, Row } from "./profile_tree.ts";
import { addressOf } from "./routes.ts";
import { statusWords } from "./sentences.ts";

/** Engines are open at first as long as all that they hold is not more than this. */
const OPEN_AT_FIRST = 60;

/** Rows that are shown, and that come with each press of the button below them. */
const ROWS = 200;

/** Pixels between what was brought into view and the edge. */
const REVEAL_MARGIN = 40;

/** State of a component beside its profile. */
export interface Marks {
  readonly status: ComponentStatus | null;
  readonly held: boolean;
  readonly listening: boolean;
  readonly faults: number;
  readonly away: boolean;
}

export interface TreeOwner {
  marksOf(id: string): Marks;
  /** Is called with the components in view, each with its status query. */
  onVisible(components: ReadonlyMap<string, string>): void;
  /** Is called with the components that are shown, in view or not, and whether all of them are searched. */
  onShown(refs: readonly string[], searching: boolean): void;
}

export class TreeView {
  readonly element: HTMLElement;
  readonly search: HTMLInputElement;
  readonly #owner: TreeOwner;
  readonly #list = make("div", { class: "tree", role: "tree", "aria-label": "Engines and components" });
  readonly #count = make("p", { class: "hint tree-count", role: "status" });
  readonly #more = button("", () => this.#showMore());
  readonly #elements = new Map<string, HTMLAnchorElement>();
  readonly #toggled = new Map<string, boolean>();
  readonly #sight: IntersectionObserver;
  readonly #inSight = new Set<string>();
  #engines: readonly EngineNode[] = [];
  #components = new Map<string, ComponentNode>();
  /** The rows that are shown, of those that there are. */
  #rows: readonly Row[] = [];
  #found: readonly Row[] = [];
  #most = ROWS;
  #selected = "";
  #focus = "";

  constructor(owner: TreeOwner) {
    this.#owner = owner;
    const attributes = {
      type: "search",
      placeholder: "Search names, types, messages",
      "aria-label": "Search",
    };
    this.search = make("input", { ...attributes, "data-testid": "inspector-search" });
    this.search.addEventListener("input", () => {
      this.#most = ROWS;
      this.#render();
      if (this.search.value === "") this.reveal();
    });
    this.search.addEventListener("keydown", (event) => this.#searchKey(event));
    this.#list.addEventListener("keydown", (event) => this.#key(event));
    this.#list.addEventListener("click", (event) => this.#click(event));
    this.#sight = new IntersectionObserver((changes) => this.#sighted(changes), { root: this.#list });
    this.element = make(
      "aside",
      { class: "tree-side", "aria-label": "Components" },
      this.search,
      this.#list,
      this.#more,
      this.#count,
    );
  }

  show(engines: readonly EngineNode[], selected: string): void {
    this.#engines = engines;
    this.#components = new Map(componentsOf(engines).map((each) => [each.ref, each]));
    this.#selected = selected;
    this.#render();
    // What has been in view before its profile was there can be asked now.
    this.#tellVisible();
  }

  /** Shows the marks of one row anew. */
  mark(id: string): void {
    const element = this.#elements.get(id);
    const row = element && this.#rows.find((each) => each.id === id);
    if (row) this.#fill(element, row);
  }

  /** Opens what the selected one stands under and brings it into view; returns whether it is there. */
  reveal(): boolean {
    for (const { id } of this.#above(this.#engines, [])) this.#toggled.set(id, true);
    this.#render();
    const place = this.#found.findIndex(({ id }) => id === this.#selected);
    if (place >= this.#most) this.#showMore(Math.ceil((place + 1) / ROWS) * ROWS);
    const element = this.#elements.get(this.#selected);
    if (!element) return false;
    this.#focusOn(this.#selected, false);
    const { top, bottom } = this.#list.getBoundingClientRect();
    const box = element.getBoundingClientRect();
    if (box.top < top) this.#list.scrollTop -= top - box.top + REVEAL_MARGIN;
    else if (box.bottom > bottom) this.#list.scrollTop += box.bottom - bottom + REVEAL_MARGIN;
    return true;
  }

  #above(engines: readonly EngineNode[], path: readonly EngineNode[]): readonly EngineNode[] {
    for (const engine of engines) {
      const here = [...path, engine];
      if (engine.id === this.#selected) return path;
      if (engine.components.some(({ ref }) => ref === this.#selected)) return here;
      const below = this.#above(engine.engines, here);
      if (below.length > 0) return below;
    }
    return [];
  }

  #isExpanded(id: string): boolean {
    return this.#toggled.get(id) ?? (this.#components.size <= OPEN_AT_FIRST || id === this.#engines[0]?.id);
  }

  #render(): void {
    this.#found = visibleRows(this.#engines, (id) => this.#isExpanded(id), this.search.value);
    this.#rows = this.#found.slice(0, this.#most);
    const ids = new Set(this.#rows.map(({ id }) => id));
    for (const [id, element] of this.#elements) if (!ids.has(id)) this.#remove(id, element);
    if (!ids.has(this.#focus))
      this.#focus = ids.has(this.#selected) ? this.#selected : (this.#rows[0]?.id ?? "");
    arrange(
      this.#list,
      this.#rows.map((row) => this.#element(row)),
    );
    this.#renderCount();
    const refs = this.#rows.flatMap(({ id, component }) => (component ? [id] : []));
    this.#owner.onShown(refs, this.search.value.trim() !== "");
  }

  #showMore(most = this.#most + ROWS): void {
    const first = this.#rows.length;
    const isPressed = document.activeElement === this.#more;
    this.#most = most;
    this.#render();
    // The button may be gone now: the keyboard goes on with what has come.
    const row = this.#rows[first];
    if (row && isPressed) this.#focusOn(row.id);
  }

  #renderCount(): void {
    const all = this.#components.size;
    const left = this.#found.length - this.#rows.length;
    this.#more.hidden = left === 0;
    setText(this.#more, `Show ${Math.min(left, ROWS)} more`);
    const found = this.#found.filter(({ component }) => component !== null).length;
    const many = `${all} ${all === 1 ? "component" : "components"}`;
    const words =
      this.search.value.trim() === "" ? many : found === 0 ? "Nothing is found." : `${found} of ${many}`;
    setText(this.#count, words);
  }

  #remove(id: string, element: Element): void {
    this.#sight.unobserve(element);
    this.#inSight.delete(id);
    this.#elements.delete(id);
    element.remove();
  }

  #element(row: Row): HTMLAnchorElement {
    let element = this.#elements.get(row.id);
    if (!element) {
      element = make("a", { class: "row", role: "treeitem", href: addressOf(row.id), "data-id": row.id });
      this.#elements.set(row.id, element);
      if (row.component) this.#sight.observe(element);
    }
    this.#fill(element, row);
    return element;
  }

  #fill(element: HTMLAnchorElement, row: Row): void {
    const marks = this.#owner.marksOf(row.id);
    element.style.setProperty("--level", String(row.level));
    element.setAttribute("aria-level", String(row.level));
    element.setAttribute("aria-selected", String(row.id === this.#selected));
    element.tabIndex = row.id === this.#focus ? 0 : -1;
    element.classList.toggle("away", marks.away);
    const before = element.dataset["shown"];
    const shown = JSON.stringify([row.expanded, row.count, row.found, marks]);
    if (before === shown) return;
    element.dataset["shown"] = shown;
    if (row.expanded !== null) element.setAttribute("aria-expanded", String(row.expanded));
    element.replaceChildren(
      ...(row.component ? componentParts(row, row.component, marks) : engineParts(row, marks)),
    );
  }

  #sighted(changes: readonly IntersectionObserverEntry[]): void {
    for (const { target, isIntersecting } of changes) {
      const { id = "" } = (target as HTMLElement).dataset;
      if (isIntersecting) this.#inSight.add(id);
      else this.#inSight.delete(id);
    }
    this.#tellVisible();
  }

  #tellVisible(): void {
    const seen = new Map<string, string>();
    for (const ref of this.#inSight) {
      const component = this.#components.get(ref);
      const query = component ? statusQuery(component.profile) : null;
      if (query !== null) seen.set(ref, query);
    }
    this.#owner.onVisible(seen);
  }

  #toggle(id: string, expanded: boolean): void {
    this.#toggled.set(id, expanded);
    this.#render();
  }

  #click(event: MouseEvent): void {
    const target = event.target instanceof Element ? event.target : null;
    const id = target?.closest<HTMLElement>("[data-id]")?.dataset["id"];
    const row = this.#rows.find((each) => each.id === id);
    if (!row) return;
    this.#focusOn(row.id, false);
    if (!target?.closest(".chevron")) return;
    event.preventDefault();
    this.#toggle(row.id, !row.expanded);
  }

  #searchKey(event: KeyboardEvent): void {
    const first = this.#rows.find(({ component }) => component !== null) ?? this.#rows[0];
    if (!first) return;
    if (event.key === "ArrowDown") {
      event.preventDefault();
      this.#focusOn(first.id);
    } else if (event.key === "Enter" && !event.isComposing) location.hash = addressOf(first.id);
  }

  /** The keys of a tree, as everywhere. */
  #key(event: KeyboardEvent): void {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const at = this.#rows.findIndex(({ id }) => id === this.#focus);
    const row = this.#rows[at];
    if (!row) return;
    const goal = this.#goal(event.key, at, row);
    if (goal === undefined) return;
    event.preventDefault();
    if (typeof goal === "boolean") this.#toggle(row.id, goal);
    else if (goal) this.#focusOn(goal.id);
  }

  /** Returns the row that a key leads to, or whether the row opens or closes; undefined for a key with no meaning. */
  #goal(key: string, at: number, row: Row): Row | boolean | null | undefined {
    const rows = this.#rows;
    switch (key) {
      case "ArrowDown":
        return rows[at + 1] ?? null;
      case "ArrowUp":
        return rows[at - 1] ?? null;
      case "Home":
        return rows[0] ?? null;
      case "End":
        return rows.at(-1) ?? null;
      case "ArrowRight":
        return row.expanded === false ? true : row.expanded ? (rows[at + 1] ?? null) : null;
      case "ArrowLeft":
        return row.expanded ? false : (rows.slice(0, at).findLast(({ level }) => level < row.level) ?? null);
      default:
        return undefined;
    }
  }

  #focusOn(id: string, move = true): void {
    const before = this.#elements.get(this.#focus);
    if (before) before.tabIndex = -1;
    this.#focus = id;
    const element = this.#elements.get(id);
    if (!element) return;
    element.tabIndex = 0;
    if (move) element.focus();
  }
}

function engineParts(row: Row, { faults, away }: Marks): Node[] {
  const chevron = make("span", { class: "chevron" }, drawing("chevron"));
  const parts: Node[] = [chevron, drawing("engine"), make("span", { class: "row-name" }, row.label)];
  if (faults > 0) parts.push(faultMark(faults));
  const count = away ? "away" : String(row.count);
  const words = away ? "" : row.count === 1 ? " component" : " components";
  parts.push(make("span", { class: "row-note" }, count, make("span", { class: "visually-hidden" }, words)));
  return parts;
}

function componentParts(row: Row, { profile }: ComponentNode, marks: Marks): Node[] {
  const { status, held, listening, faults, away } = marks;
  const dot = make("span", { class: "dot", "data-status": status ?? "", title: statusWords(status) });
  const parts: Node[] = [dot, make("span", { class: "row-name" }, row.label)];
  if (row.found !== "") parts.push(make("span", { class: "row-found" }, row.found));
  if (faults > 0) parts.push(faultMark(faults));
  if (listening) parts.push(make("span", { class: "row-mark" }, drawing("event"), hidden("listening")));
  if (held) parts.push(make("span", { class: "row-mark row-held" }, "bound"));
  const unusual = away
    ? "away"
    : status !== null && status !== "READY"
      ? codeWords(status)
      : (profile.function ?? "");
  parts.push(make("span", { class: "row-note" }, unusual));
  return parts;
}

function faultMark(count: number): HTMLElement {
  return make(
    "span",
    { class: "row-mark row-fault" },
    String(count),
    hidden(count === 1 ? "error" : "errors"),
  );
}

function hidden(words: string): HTMLElement {
  return make("span", { class: "visually-hidden" }, ` ${words}`);
}
