/** The inspector: every component of every engine, as its profile says it is. */

import { engineOf } from "../../sdk/index.ts";
import type { Client, ComponentEntry, ComponentStatus } from "../../sdk/index.ts";
import { make } from "../dom/elements.ts";
import type { Listing } from "../model/bodies.ts";
import { ComponentPanel } from "./component_panel.ts";
import type { Absence } from "./component_panel.ts";
import { EnginePanel } from "./engine_panel.ts";
import { EntryTree } from "./entry_tree.ts";
import { FaultLog } from "./fault_log.ts";
import { BoundComponents } from "./bound_components.ts";
import { ProfileLoader } from "./profile_loader.ts";
import { componentsOf, engineTree, enginesOf, statusQuery, withAway } from "./profile_tree.ts";
import type { ComponentNode, EngineNode } from "./profile_tree.ts";
import { StatusWatch } from "./status_watch.ts";
import { TreeView } from "./tree_view.ts";
import type { Marks } from "./tree_view.ts";

export class Inspector {
  readonly #client: Client;
  readonly #root: HTMLElement;
  readonly #tree: TreeView;
  readonly #place = make("div", { class: "place" });
  readonly #bound = new BoundComponents();
  /** What the present session's profile had when it was read last. */
  #listed: ReadonlySet<string> = new Set();
  readonly #faults: FaultLog;
  readonly #entryTree = new EntryTree();
  readonly #loader: ProfileLoader;
  readonly #watch: StatusWatch;
  readonly #panels = new Map<string, ComponentPanel>();
  readonly #status = new Map<string, ComponentStatus | null>();
  #seen: ReadonlyMap<string, string> = new Map();
  #listing: Listing | null = null;
  #engines: readonly EngineNode[] | null = null;
  #engineById: ReadonlyMap<string, EngineNode> = new Map();
  #components = new Map<string, ComponentNode>();
  /** Those that were opened and have left: what was typed in their panels is still of use. */
  readonly #left = new Map<string, ComponentNode>();
  #selected = "";
  /** What is selected was brought into view in the tree. */
  #revealed = false;
  #connected = false;
  #shown = false;
  #engineShown = "";
  #enginePanel: EnginePanel | null = null;

  constructor(client: Client, root: HTMLElement) {
    this.#client = client;
    this.#root = root;
    this.#tree = new TreeView({
      marksOf: (id) => this.#marksOf(id),
      onVisible: (components) => {
        this.#seen = components;
        this.#watchStatus();
      },
      onShown: (refs, searching) => this.#load(refs, searching),
    });
    this.#loader = new ProfileLoader(client, () => this.#loaded());
    this.#watch = new StatusWatch(client, (ref, status) => this.#statusIs(ref, status));
    this.#faults = new FaultLog(client, () => this.#faultsChanged());
    client.on("traffic", (traffic) => {
      if (this.#bound.observe(traffic)) this.#boundChanged();
    });
    root.append(this.#tree.element, this.#place);
    this.#render();
  }

  /** @param listing null while it has not been read */
  update(listing: Listing | null, connected: boolean): void {
    this.#connected = connected;
    this.#listing = listing;
    this.#build();
    // What was bound again before the profile lists it is held: only what this session had listed can leave it.
    this.#bound.lose((ref) => !connected || (this.#listed.has(ref) && !this.#components.has(ref)));
    this.#listed = new Set(connected && listing !== null ? this.#components.keys() : []);
    for (const ref of this.#status.keys())
      if (!connected || !this.#components.has(ref)) this.#status.delete(ref);
    this.#boundChanged();
    this.#render();
  }

  /** Makes the tree of what there is, with the profiles that are loaded. */
  #build(): void {
    if (this.#listing === null) return;
    this.#engines =
      "engines" in this.#listing
        ? this.#entryTree.build(this.#listing.engines, this.#loader)
        : engineTree(this.#listing);
    this.#engineById = new Map(enginesOf(this.#engines).map((engine) => [engine.id, engine]));
    const now = new Map(componentsOf(this.#engines).map((each) => [each.ref, each]));
    for (const [ref, component] of this.#components)
      if (!now.has(ref) && this.#panels.has(ref)) this.#left.set(ref, component);
    this.#components = now;
  }

  #loaded(): void {
    this.#build();
    this.#render();
  }

  /** Loads the profiles of what is shown; while it is searched, of all, since names in them are searched too. */
  #load(refs: readonly string[], searching: boolean): void {
    if (this.#listing === null || !("engines" in this.#listing)) return;
    const { engines } = this.#listing;
    const one = (ref: string): readonly ComponentEntry[] =>
      engines.get(engineOf(ref))?.components?.filter(({ component_ref }) => component_ref === ref) ?? [];
    const all = searching ? [...engines.values()].flatMap(({ components = [] }) => components) : [];
    this.#loader.want([...one(this.#selected), ...refs.flatMap(one), ...all]);
  }

  /** Goes to an engine or component; the empty id is the beginning. */
  select(id: string): void {
    if (id === this.#selected) return;
    this.#selected = id;
    this.#revealed = false;
    this.#render();
    this.#panels.get(id)?.refresh();
    if (this.#shown) scrollTo({ top: 0 });
    // On a narrow screen the tree has given way to what was chosen in it.
    if (!this.#tree.element.checkVisibility()) this.#place.querySelector("h2")?.focus();
  }

  /** Components are asked for their status only while the inspector is in view. */
  set shown(shown: boolean) {
    this.#shown = shown;
    this.#watchStatus();
    if (shown) this.#panels.get(this.#selected)?.refresh();
  }

  search(): void {
    this.#tree.search.focus();
    this.#tree.search.select();
  }

  #marksOf(id: string): Marks {
    const panel = this.#panels.get(id);
    return {
      status: this.#status.get(id) ?? null,
      held: this.#bound.has(id),
      listening: panel?.listening ?? false,
      faults: this.#faults.about(id).length,
      away: this.#absence(id) === "away",
    };
  }

  #absence(id: string): Absence {
    if (!this.#connected) return "offline";
    const there = id.includes("/") ? this.#components.has(id) : this.#engine(id) !== undefined;
    return there ? null : "away";
  }

  #engine(id: string): EngineNode | undefined {
    return this.#engineById.get(id);
  }

  #render(): void {
    this.#root.classList.toggle("chosen", this.#selected !== "");
    if (this.#engines === null) {
      const words = this.#connected ? "Reading what there is" : "Waiting for the gateway";
      return this.#place.replaceChildren(make("p", { class: "empty-state", role: "status" }, words));
    }
    const away = this.#left.get(this.#selected) ?? null;
    this.#tree.show(withAway(this.#engines, this.#selected, away), this.#selected);
    this.#revealed ||= this.#tree.reveal();
    this.#showPlace();
    this.#watchStatus();
  }

  #showPlace(): void {
    const id = this.#selected === "" ? (this.#engines?.[0]?.id ?? "") : this.#selected;
    const component = this.#components.get(id) ?? this.#left.get(id);
    if (component) return this.#showComponent(component);
    if (id.includes("/")) return this.#showUnknown(id);
    this.#showEngine(id);
  }

  #showComponent({ ref, profile, isLoaded }: ComponentNode): void {
    if (!isLoaded && !this.#panels.has(ref))
      return this.#put(make("p", { class: "empty-state", role: "status" }, "Reading what it understands"));
    const panel = this.#panels.get(ref) ?? this.#newPanel(ref);
    panel.update(isLoaded ? profile : null, this.#absence(ref));
    panel.setStatus(this.#status.get(ref) ?? null);
    panel.setHeld(this.#bound.has(ref));
    panel.setFaults(this.#faults.about(ref));
    this.#put(panel.element);
  }

  #newPanel(ref: string): ComponentPanel {
    const panel = new ComponentPanel(
      { client: this.#client, onWork: () => this.#watch.poke(ref), onEvent: () => this.#tree.mark(ref) },
      ref,
    );
    this.#panels.set(ref, panel);
    return panel;
  }

  #showEngine(id: string): void {
    const absence = this.#absence(id);
    const engine = this.#engine(id) ?? { id, profile: null, components: [], engines: [] };
    this.#loadEngine(engine);
    const { profile, components, engines } = engine;
    const below = engines.map((each) => [each.id, componentsOf([each]).length]);
    const shown = JSON.stringify([id, profile, components, below, absence]);
    if (shown !== this.#engineShown || this.#enginePanel === null) {
      const left = absence === "away" ? "This engine has left. As soon as it is back, it is shown here." : "";
      this.#enginePanel = new EnginePanel(
        engine,
        absence === "offline" ? "There is no connection to the gateway." : left,
        this.#enginePanel?.element.dataset["engine"] === id ? this.#enginePanel : null,
      );
      this.#engineShown = shown;
    }
    this.#enginePanel.setFaults(this.#faults.about(id));
    this.#put(this.#enginePanel.element);
  }

  #loadEngine(engine: EngineNode): void {
    if (this.#listing === null || !("engines" in this.#listing) || !this.#connected) return;
    const entry = this.#listing.engines.get(engine.id);
    // The main engine is in every profile.
    const [inner] = entry?.parent_id === "" ? [] : componentsOf(engine.engines);
    if (entry) void this.#loader.wantEngine(entry, inner?.ref ?? "");
  }

  #showUnknown(id: string): void {
    const words = `There is no component ${id} here. Choose one in the list; as soon as this one connects, it is shown.`;
    this.#put(make("p", { class: "empty-state", role: "status" }, words));
  }

  #put(element: HTMLElement): void {
    if (this.#place.firstElementChild !== element) this.#place.replaceChildren(element);
  }

  #watchStatus(): void {
    const wanted = new Map(this.#shown && this.#connected ? this.#seen : []);
    const selected = this.#components.get(this.#selected);
    const query = selected ? statusQuery(selected.profile) : null;
    if (this.#shown && this.#connected && query !== null) wanted.set(this.#selected, query);
    for (const ref of wanted.keys()) if (!this.#components.has(ref)) wanted.delete(ref);
    this.#watch.watch(wanted, this.#selected);
  }

  #statusIs(ref: string, status: ComponentStatus | null): void {
    if (!this.#connected || !this.#components.has(ref)) return;
    this.#status.set(ref, status);
    this.#tree.mark(ref);
    if (ref === this.#selected) this.#panels.get(ref)?.setStatus(status);
  }

  #boundChanged(): void {
    for (const [ref, panel] of this.#panels) panel.setHeld(this.#bound.has(ref));
    for (const ref of this.#components.keys()) this.#tree.mark(ref);
  }

  #faultsChanged(): void {
    if (this.#engines === null) return;
    for (const { id } of enginesOf(this.#engines)) this.#tree.mark(id);
    for (const ref of this.#components.keys()) if (this.#faults.about(ref).length > 0) this.#tree.mark(ref);
    this.#showPlace();
  }
}
