/** Panel of one component, made of its profile alone: everything in it can be tried. */

import { componentUrn } from "../../sdk/index.ts";
import type { HRIComponentProfile, ComponentStatus, Client } from "../../sdk/index.ts";
import { make, setText } from "../dom/elements.ts";
import { codeWords } from "../model/code_words.ts";
import { sentence } from "../model/plain_words.ts";
import { CommandCard } from "./command_card.ts";
import type { Card, ComponentBench } from "./component_bench.ts";
import { arrange, disclosure, jsonBlock } from "./controls.ts";
import { EventCard } from "./event_card.ts";
import type { Fault } from "./fault_log.ts";
import { drawing } from "./icons.ts";
import { FaultGroup, Group, copyable } from "./panel_parts.ts";
import { ParameterCard } from "./parameter_card.ts";
import { OutcomeView } from "./outcome_view.ts";
import { statusQuery } from "./profile_tree.ts";
import { QueryCard } from "./query_card.ts";
import { addressOf } from "./routes.ts";
import { refusal, statusWords } from "./sentences.ts";
import type { Drafts } from "./value_form.ts";

export interface PanelOwner {
  readonly client: Client;
  /** Is called after an operation that may have changed the component's status. */
  onWork(ref: string): void;
  /** Is called for an event of the component, and when a subscription begins or ends. */
  onEvent(ref: string): void;
}

/** Why a component cannot be used; null when it can. */
export type Absence = "away" | "offline" | null;

const ABSENT: Readonly<Record<"away" | "offline", string>> = {
  away: "This component has left. What you typed stays, and all goes on when it is back.",
  offline: "There is no connection to the gateway. What you typed stays, and all goes on when it is back.",
};

export class ComponentPanel {
  readonly element: HTMLElement;
  readonly ref: string;
  readonly #owner: PanelOwner;
  readonly #bench: ComponentBench;
  readonly #drafts: Drafts = new Map();
  readonly #cards = new Map<string, Card>();
  readonly #status = make("span", { class: "status", role: "status", "data-testid": "component-status" });
  readonly #function = make("span", { class: "chip" });
  readonly #ids = make("dl", { class: "panel-ids" });
  readonly #absent = make("p", { class: "absent", role: "status", hidden: "" });
  readonly #bound = make("span", { class: "hint", "data-testid": "bind-state" });
  readonly #bind = make("button", { type: "button", class: "button small run", "data-testid": "bind" });
  readonly #outcome = new OutcomeView();
  readonly #parameters = new Group("parameters", "Parameters", "parameter");
  readonly #commands = new Group("commands", "Commands", "command");
  readonly #queries = new Group("queries", "Queries", "query");
  readonly #events = new Group("events", "Events", "event");
  readonly #faults = new FaultGroup();
  readonly #raw = make("div", { class: "raw" });
  #profile: HRIComponentProfile = { identifier: { code: "" }, name: "" };
  #shown = "";
  #held = false;
  #absence: Absence = null;

  constructor(owner: PanelOwner, ref: string) {
    this.#owner = owner;
    this.ref = ref;
    this.#bench = {
      client: owner.client,
      ref,
      drafts: this.#drafts,
      bind: () => owner.client.bind(ref),
      onWork: () => owner.onWork(ref),
      onEvent: () => owner.onEvent(ref),
    };
    this.#bind.addEventListener("click", () => void this.#toggleBind());
    const groups = [this.#parameters, this.#commands, this.#queries, this.#events, this.#faults];
    const jumps = make("div", { class: "jumps" }, ...groups.map(({ jump }) => jump));
    this.element = make(
      "article",
      { class: "panel", "data-ref": ref },
      this.#head(),
      this.#absent,
      jumps,
      ...groups.map(({ element }) => element),
      this.#raw,
    );
    for (const attempt of ["click", "submit"]) {
      this.element.addEventListener(attempt, (event) => this.#hold(event), { capture: true });
    }
    this.setStatus(null);
    this.setHeld(false);
  }

  get listening(): boolean {
    return [...this.#cards.values()].some((card) => card instanceof EventCard && card.listening);
  }

  /**
   * Shows a profile; cards of messages that are as they were stay, with all that is in them.
   *
   * @param profile null while it is not loaded: the former one stays
   */
  update(profile: HRIComponentProfile | null, absence: Absence): void {
    const back = this.#absence !== null && absence === null;
    this.#absence = absence;
    this.#profile = profile ?? this.#profile;
    const shown = JSON.stringify(this.#profile);
    if (shown !== this.#shown) this.#render(this.#profile);
    this.#shown = shown;
    this.element.classList.toggle("away", absence !== null);
    this.#absent.hidden = absence === null;
    setText(this.#absent, absence === null ? "" : ABSENT[absence]);
    for (const each of this.element.querySelectorAll("button.run")) {
      each.setAttribute("aria-disabled", String(absence !== null));
    }
    if (back) this.refresh();
  }

  /** Reads again what may have changed. */
  refresh(): void {
    if (this.#absence !== null) return;
    for (const card of this.#cards.values()) card.refresh?.();
  }

  setStatus(status: ComponentStatus | null): void {
    this.#status.dataset["status"] = status ?? "";
    this.#status.title = statusWords(status);
    setText(this.#status, sentence(codeWords(status ?? "unknown")));
  }

  setHeld(held: boolean): void {
    this.#held = held;
    setText(this.#bind, held ? "Release" : "Bind");
    this.#bind.classList.toggle("primary", !held && this.#profile.function === "actuation");
    // Whether a component without a class has to be bound is for its engine to say.
    const { function: kind = null } = this.#profile;
    const free = kind === null ? "Not bound" : "Needs no binding";
    const unheld = kind === "actuation" ? "Not bound: it takes no commands yet" : free;
    setText(this.#bound, held ? "Bound by this page" : unheld);
  }

  setFaults(faults: readonly Fault[]): void {
    this.#faults.show(faults);
  }

  /** Blocks operations on an absent component; results and typed values stay usable. */
  #hold(event: Event): void {
    const tries = event.type === "submit" || (event.target as Element).closest(".run") !== null;
    if (this.#absence === null || !tries) return;
    event.preventDefault();
    event.stopPropagation();
  }

  #head(): HTMLElement {
    const back = make("a", { class: "back", href: addressOf("") }, drawing("back"), "All components");
    const name = this.ref.slice(this.ref.indexOf("/") + 1);
    const title = make("h2", { tabindex: "-1" }, name);
    const binding = make("div", { class: "binding" }, this.#bound, this.#bind);
    const line = make("div", { class: "panel-title" }, title, this.#status, this.#function, binding);
    return make("header", { class: "panel-head" }, back, line, this.#ids, this.#outcome.element);
  }

  #render(profile: HRIComponentProfile): void {
    const {
      command_profiles = [],
      query_profiles = [],
      event_profiles = [],
      parameter_profiles = [],
    } = profile;
    const { function: kind, sub_component_profiles = [] } = profile;
    setText(this.#function, kind ?? "");
    this.#function.hidden = !kind;
    this.#status.hidden = statusQuery(profile) === null;
    this.#ids.replaceChildren(
      copyable("Reference", this.ref),
      copyable("Type", componentUrn(profile)),
      ...sub_component_profiles.map((urn) => copyable("Includes", urn)),
    );
    const kept = new Set<string>();
    const fill = <T>(group: Group, profiles: readonly T[], make_: (each: T) => Card): void => {
      const cards = profiles.map((each) =>
        this.#card(`${group.element.dataset["group"]} ${JSON.stringify(each)}`, kept, () => make_(each)),
      );
      // A message that a profile lists twice is one.
      const elements = [...new Set(cards.map(({ element }) => element))];
      arrange(group.body, elements);
      group.count = elements.length;
      group.shown = elements.length > 0;
    };
    const bench = this.#bench;
    const sets = parameter_profiles.length > 0 ? [parameter_profiles] : [];
    fill(this.#parameters, sets, (each) => new ParameterCard(bench, each));
    this.#parameters.count = parameter_profiles.length;
    fill(this.#commands, command_profiles, (each) => new CommandCard(bench, each));
    fill(this.#queries, query_profiles, (each) => new QueryCard(bench, each));
    fill(this.#events, event_profiles, (each) => new EventCard(bench, each));
    for (const [key, card] of this.#cards) {
      if (kept.has(key)) continue;
      card.close?.();
      this.#cards.delete(key);
    }
    this.#raw.replaceChildren(disclosure("Profile as JSON", () => jsonBlock(profile, "Profile")));
    this.setHeld(this.#held);
  }

  #card(key: string, kept: Set<string>, make_: () => Card): Card {
    const card = this.#cards.get(key) ?? make_();
    if (!this.#cards.has(key)) card.refresh?.();
    this.#cards.set(key, card);
    kept.add(key);
    return card;
  }

  async #toggleBind(): Promise<void> {
    const { client } = this.#owner;
    const held = this.#held;
    this.#outcome.clear();
    try {
      await (held ? client.release(this.ref) : client.bind(this.ref));
    } catch (error) {
      this.#outcome.refused(refusal(held ? "release" : "bind", error));
    }
  }
}
