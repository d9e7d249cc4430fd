/** Card of one event: a switch to subscribe to it, and the newest events. */

import { onlyComponent } from "../../sdk/index.ts";
import type { Claim, Client, EventMessageProfile, RoISEvent, Subscription } from "../../sdk/index.ts";
import { make, setText } from "../dom/elements.ts";
import { formatTime } from "../model/format.ts";
import type { Card, ComponentBench } from "./component_bench.ts";
import { button } from "./controls.ts";
import { RequestPreview, messageHead } from "./message_head.ts";
import { OutcomeView } from "./outcome_view.ts";
import { gist, resultsTable } from "./results_view.ts";
import { refusal } from "./sentences.ts";

/** How many events of one kind are kept. */
const EVENTS_KEPT = 100;

interface Heard {
  readonly event: RoISEvent;
  readonly at: number;
}

export class EventCard implements Card {
  readonly element: HTMLElement;
  readonly #bench: ComponentBench;
  readonly #name: string;
  readonly #toggle: HTMLButtonElement;
  readonly #list = make("ol", { class: "heard", hidden: "" });
  readonly #count = make("span", { class: "hint" });
  readonly #clear: HTMLButtonElement;
  readonly #outcome = new OutcomeView();
  readonly #stops: (() => void)[];
  #subscription: Promise<Subscription> | null = null;
  #waiting: Heard[] = [];
  #frame = 0;
  #total = 0;

  constructor(bench: ComponentBench, { name, results = [] }: EventMessageProfile) {
    this.#bench = bench;
    this.#name = name;
    const condition = onlyComponent(bench.ref);
    const request = new RequestPreview("rois.event.subscribe", () => ({ event_type: name, condition }));
    const label = `Listen to ${name}`;
    this.#toggle = make("button", {
      type: "button",
      role: "switch",
      class: "switch run",
      "aria-label": label,
    });
    this.#toggle.addEventListener("click", () => void (this.listening ? this.#stop() : this.#listen()));
    this.#clear = button("Clear", () => this.#clearEvents(), "quiet");
    this.element = make(
      "div",
      { class: "message", "data-kind": "event", "data-name": name },
      messageHead(name, results, [], this.#count, this.#clear, request.toggle, this.#toggle),
      request.element,
      this.#outcome.element,
      this.#list,
    );
    const isMine = (claim: Claim): boolean =>
      claim.kind === "subscription" && claim.eventType === name && claim.condition === condition;
    this.#stops = [
      bench.client.on("lost", (claim) => {
        if (isMine(claim)) this.#outcome.refused(refusal("subscribe", claim.error));
      }),
      bench.client.on("restored", (claim) => {
        if (isMine(claim)) this.#outcome.clear();
      }),
    ];
    this.#render();
  }

  get listening(): boolean {
    return this.#subscription !== null;
  }

  close(): void {
    for (const stop of this.#stops) stop();
    if (this.listening) void this.#stop();
  }

  async #listen(): Promise<void> {
    const { client, ref } = this.#bench;
    this.#outcome.clear();
    const subscription = client.subscribe(this.#name, onlyComponent(ref), (event) => this.#addEvent(event));
    this.#subscription = subscription;
    this.#render();
    try {
      await subscription;
    } catch (error) {
      if (this.#subscription === subscription) this.#subscription = null;
      this.#outcome.refused(refusal("subscribe", error));
    }
    this.#render();
  }

  async #stop(): Promise<void> {
    const subscription = this.#subscription;
    this.#subscription = null;
    this.#outcome.clear();
    this.#render();
    await subscription?.then(
      (made) => made.cancel(),
      () => undefined,
    );
  }

  #addEvent(event: RoISEvent): void {
    this.#total += 1;
    this.#waiting.push({ event, at: Date.now() });
    if (this.#waiting.length > EVENTS_KEPT) this.#waiting.shift();
    // A burst of events is one change of the page.
    this.#frame ||= requestAnimationFrame(() => this.#flush());
  }

  #flush(): void {
    this.#frame = 0;
    const rows = this.#waiting.map((heard) => this.#row(heard)).reverse();
    this.#waiting = [];
    this.#list.prepend(...rows);
    while (this.#list.childElementCount > EVENTS_KEPT) this.#list.lastElementChild?.remove();
    this.#render();
    this.#bench.onEvent();
  }

  #clearEvents(): void {
    this.#list.replaceChildren();
    this.#waiting = [];
    this.#total = 0;
    this.#render();
  }

  #row({ event, at }: Heard): HTMLLIElement {
    const summary = make("summary", {}, make("time", {}, formatTime(at)), gist(event.results));
    const details = make("details", {}, summary);
    // Most events are never opened: their details are written when they are.
    details.addEventListener("toggle", () => {
      if (details.open && details.childElementCount === 1)
        details.append(eventDetail(this.#bench.client, event));
    });
    return make("li", { "data-event": event.event_id }, details);
  }

  #render(): void {
    this.#toggle.setAttribute("aria-checked", String(this.listening));
    this.element.classList.toggle("listening", this.listening);
    this.#list.hidden = this.#total === 0;
    this.#clear.hidden = this.#total === 0;
    const more = this.#total > EVENTS_KEPT ? `, the newest ${EVENTS_KEPT} are kept` : "";
    const heard = this.#total === 0 ? "listening" : `${this.#total} heard${more}`;
    setText(this.#count, this.listening || this.#total > 0 ? heard : "");
    this.#bench.onEvent();
  }
}

/** Makes the details of an event: its results, and a button that asks the engine for what it still has. */
function eventDetail(client: Client, event: RoISEvent): HTMLElement {
  const outcome = new OutcomeView();
  const ask = async (): Promise<void> => {
    try {
      outcome.done("the engine remembers", await client.getEventDetail(event.event_id));
    } catch (error) {
      outcome.refused(refusal("detail", error));
    }
  };
  const until = event.expire === "" ? "" : `Details until ${new Date(event.expire).toLocaleTimeString()}`;
  const known = make("p", { class: "hint" }, until);
  const asking = button("Ask for its details", () => void ask());
  // An engine that sends no results along has them in the details alone.
  if (event.results.length === 0) void ask();
  return make("div", { class: "detail" }, resultsTable(event.results), known, asking, outcome.element);
}
