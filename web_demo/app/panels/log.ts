/** The list of every RoIS message that was sent or received. */

import type { Client, Traffic } from "../../sdk/index.ts";
import { byRole, byTestId, make, setText } from "../dom/elements.ts";
import { formatTime } from "../model/format.ts";
import { LogModel, MAX_ENTRIES, matches, pretty } from "../model/log_model.ts";
import type { LogEntry } from "../model/log_model.ts";

/** The list follows its end while it is scrolled this close to it, in pixels. */
const NEAR_END = 40;

export class MessageLog {
  readonly #model = new LogModel();
  readonly #list = byTestId("log", HTMLOListElement);
  readonly #filter = byTestId("log-filter", HTMLInputElement);
  readonly #pause = byTestId("log-pause", HTMLButtonElement);
  readonly #count = byRole("log-count", HTMLElement);
  #paused = false;
  #missed = 0;
  #waiting: LogEntry[] = [];
  #frame = 0;
  /** The row that the keyboard was in last; null before. */
  #chosen: HTMLElement | null = null;
  /** The one row that the Tab key goes to: the chosen one, else the newest. */
  #stop: HTMLElement | null = null;
  /** The end is in view, and stays so. */
  #following = true;
  #scrolled = 0;

  constructor(client: Client) {
    client.on("traffic", (traffic) => this.#add(traffic));
    this.#list.addEventListener("scroll", () => {
      const { scrollHeight, scrollTop, clientHeight } = this.#list;
      if (scrollHeight - scrollTop - clientHeight < NEAR_END) this.#following = true;
      else if (scrollTop < this.#scrolled) this.#following = false;
      this.#scrolled = scrollTop;
    });
    placeWhereThereIsRoom();
    // The list is as high as the rest of the page leaves it.
    new ResizeObserver(() => this.#follow()).observe(this.#list);
    this.#list.addEventListener("focusin", ({ target }) => {
      if (target instanceof HTMLElement) this.#chosen = target.closest("li");
      this.#rove();
    });
    this.#list.addEventListener("keydown", (event) => this.#keyDown(event));
    this.#filter.addEventListener("input", () => this.#rebuild());
    this.#pause.addEventListener("click", () => this.#setPaused(!this.#paused));
    byTestId("log-clear", HTMLButtonElement).addEventListener("click", () => {
      this.#model.clear();
      this.#rebuild();
    });
  }

  #add(traffic: Traffic): void {
    const entry = this.#model.add(traffic);
    if (this.#paused) {
      this.#missed += 1;
      return this.#renderCount();
    }
    this.#waiting.push(entry);
    // A burst of messages is one change of the page. A hidden page paints nothing, so the rows wait in a bounded list.
    if (this.#waiting.length > MAX_ENTRIES) this.#waiting.shift();
    this.#frame ||= requestAnimationFrame(() => this.#flush());
  }

  #flush(): void {
    this.#frame = 0;
    for (const entry of this.#waiting.filter((each) => matches(each, this.#filter.value))) {
      const before =
        entry.repeats > 1 ? this.#list.querySelector(`:scope > [data-number="${entry.number}"]`) : null;
      if (before) this.#replace(before, row(entry));
      else this.#list.append(row(entry));
    }
    this.#waiting = [];
    while (this.#list.childElementCount > MAX_ENTRIES) this.#dropOldest();
    this.#rove();
    this.#follow();
    this.#renderCount();
  }

  /** The arrow keys, Home and End go from row to row; right opens one, left closes it. */
  #keyDown(event: KeyboardEvent): void {
    const here = event.target instanceof HTMLElement ? event.target.closest("li") : null;
    if (!here || event.ctrlKey || event.metaKey || event.altKey) return;
    const details = here.querySelector("details");
    const to: Readonly<Record<string, Element | null>> = {
      ArrowUp: here.previousElementSibling,
      ArrowDown: here.nextElementSibling,
      Home: this.#list.firstElementChild,
      End: this.#list.lastElementChild,
    };
    if (event.key === "ArrowRight" && details) details.open = true;
    else if (event.key === "ArrowLeft" && details) details.open = false;
    else if (event.key in to) summaryOf(to[event.key])?.focus();
    else return;
    event.preventDefault();
  }

  #rove(): void {
    const row = this.#chosen?.isConnected ? this.#chosen : this.#list.lastElementChild;
    const stop = summaryOf(row);
    if (stop === this.#stop) return;
    if (this.#stop) this.#stop.tabIndex = -1;
    if (stop) stop.tabIndex = 0;
    this.#stop = stop;
  }

  /** What was open stays so, and so does the keyboard's focus. */
  #replace(before: Element, after: HTMLLIElement): void {
    const focused = before.contains(document.activeElement);
    const details = after.querySelector("details");
    if (details && before.querySelector("details[open]")) details.open = true;
    before.replaceWith(after);
    if (focused) summaryOf(after)?.focus({ preventScroll: true });
  }

  #dropOldest(): void {
    const oldest = this.#list.firstElementChild;
    if (oldest?.contains(document.activeElement))
      summaryOf(oldest.nextElementSibling)?.focus({ preventScroll: true });
    oldest?.remove();
  }

  #follow(): void {
    if (!this.#following) return;
    this.#list.scrollTop = this.#list.scrollHeight;
    this.#scrolled = this.#list.scrollTop;
  }

  #rebuild(): void {
    this.#waiting = [...this.#model.entries];
    this.#missed = 0;
    this.#list.replaceChildren();
    this.#flush();
  }

  #setPaused(paused: boolean): void {
    this.#paused = paused;
    this.#pause.setAttribute("aria-pressed", String(paused));
    setText(this.#pause, paused ? "Continue" : "Pause");
    if (paused) this.#renderCount();
    else this.#rebuild();
  }

  #renderCount(): void {
    const shown = this.#list.childElementCount;
    const all = this.#model.entries.length - this.#missed;
    const filtered = this.#filter.value === "" ? `${shown}` : `${shown} of ${all}`;
    setText(this.#count, this.#paused ? `paused, ${this.#missed} more` : filtered);
  }
}

function summaryOf(row: Element | null | undefined): HTMLElement | null {
  return row?.querySelector("summary") ?? null;
}

/** Under the picture where that leaves room, else at the end of the column of cards. */
function placeWhereThereIsRoom(): void {
  const card = byRole("card-log", HTMLElement);
  const isRoomy = matchMedia("(min-width: 1080px) and (min-height: 900px)");
  const place = (): void => byRole(isRoomy.matches ? "scene" : "side", HTMLElement).append(card);
  isRoomy.addEventListener("change", place);
  place();
}

function row(entry: LogEntry): HTMLLIElement {
  const { direction, at, kind, method, elapsed, message } = entry.traffic;
  const name = kind === "violation" ? "not understood" : method;
  const took = elapsed === undefined ? "" : `${elapsed < 10 ? elapsed.toFixed(1) : elapsed.toFixed(0)} ms`;
  const summary = make(
    "summary",
    { tabindex: "-1", "data-role": "log-row" },
    make("span", { class: "direction", title: direction }, direction === "sent" ? "↑" : "↓"),
    make("time", {}, formatTime(at)),
    make("span", { class: "method" }, name),
    make("span", { class: "gist" }, entry.summary),
    make("span", { class: "took" }, entry.repeats > 1 ? `× ${entry.repeats}` : took),
  );
  const details = make("details", {}, summary);
  // Most messages are never opened: their JSON is written when they are.
  details.addEventListener("toggle", () => {
    if (details.open && details.childElementCount === 1) details.append(make("pre", {}, pretty(message)));
  });
  const number = String(entry.number);
  const attributes = {
    "data-number": number,
    "data-direction": direction,
    "data-kind": kind,
    "data-method": method,
  };
  return make("li", entry.failed ? { ...attributes, "data-failed": "" } : attributes, details);
}
