/** An engine: what is in it, what it says of itself, and the errors that it notified. */

import { componentType } from "../../sdk/index.ts";
import { make } from "../dom/elements.ts";
import { disclosure, jsonBlock } from "./controls.ts";
import type { Fault } from "./fault_log.ts";
import { drawing } from "./icons.ts";
import { FaultGroup, Group, copyable } from "./panel_parts.ts";
import type { ComponentNode, EngineNode } from "./profile_tree.ts";
import { componentsOf, enginesOf } from "./profile_tree.ts";
import { addressOf } from "./routes.ts";

export class EnginePanel {
  readonly element: HTMLElement;
  readonly #faults = new FaultGroup();

  constructor(engine: EngineNode, absent: string) {
    const { profile, components, engines, id } = engine;
    const parts = [engineHead(engine)];
    if (absent !== "") parts.push(make("p", { class: "absent", role: "status" }, absent));
    if (engines.length > 0) parts.push(listGroup("engines", "Engines", engines.map(engineLink)));
    if (components.length > 0)
      parts.push(listGroup("components", "Components", components.map(componentLink)));
    if (engines.length + components.length === 0 && absent === "") parts.push(emptyEngine());
    const parameters = profile?.parameter_profiles ?? [];
    if (parameters.length > 0) {
      const rows = parameters.map(({ name, data_type_ref, default_value = "" }) =>
        make(
          "div",
          { class: "link-row" },
          make("span", { class: "row-name" }, name),
          make("span", { class: "type" }, data_type_ref.code),
          make("span", { class: "hint" }, default_value),
        ),
      );
      parts.push(listGroup("engine-parameters", "Parameters", rows));
    }
    parts.push(this.#faults.element);
    if (profile)
      parts.push(
        make(
          "div",
          { class: "raw" },
          disclosure("Profile as JSON", () => jsonBlock(profile, "Profile")),
        ),
      );
    this.element = make("article", { class: "panel", "data-engine": id }, ...parts);
  }

  setFaults(faults: readonly Fault[]): void {
    this.#faults.show(faults);
  }
}

function engineHead({ id, profile, components, engines }: EngineNode): HTMLElement {
  const back = make("a", { class: "back", href: addressOf("") }, drawing("back"), "All components");
  const title = make("h2", { tabindex: "-1" }, id);
  const chip = make("span", { class: "chip" }, "engine");
  const below = componentsOf(engines).length;
  const inAll = below === 0 ? "" : ` in ${plural(enginesOf(engines).length + 1, "engine")}`;
  const count = make("span", { class: "hint" }, `${plural(components.length + below, "component")}${inAll}`);
  const { code = id, authority = "", codebook_ref = "", version = "" } = profile?.identifier ?? {};
  const said = { Identifier: code, Authority: authority, Codebook: codebook_ref, Version: version };
  const ids = Object.entries(said).filter(([, text]) => text !== "");
  return make(
    "header",
    { class: "panel-head" },
    back,
    make("div", { class: "panel-title" }, title, chip, count),
    make("dl", { class: "panel-ids" }, ...ids.map(([label, text]) => copyable(label, text))),
  );
}

function listGroup(kind: string, title: string, rows: readonly Node[]): HTMLElement {
  const group = new Group(kind, title, kind === "engine-parameters" ? "parameter" : "engine");
  group.body.append(...rows);
  group.count = rows.length;
  return group.element;
}

function engineLink({ id, components, engines }: EngineNode): HTMLElement {
  const all = [...components, ...componentsOf(engines)];
  const types = [...new Set(all.map(({ profile }) => componentType(profile)))];
  return make(
    "a",
    { class: "link-row", href: addressOf(id) },
    make("span", { class: "row-name" }, id),
    make("span", { class: "type" }, plural(all.length, "component")),
    make("span", { class: "hint clipped" }, types.join(", ")),
  );
}

function componentLink({ ref, name, profile }: ComponentNode): HTMLElement {
  const {
    command_profiles = [],
    query_profiles = [],
    event_profiles = [],
    parameter_profiles = [],
  } = profile;
  const counts = [
    [command_profiles.length, "command"],
    [query_profiles.length, "query"],
    [event_profiles.length, "event"],
    [parameter_profiles.length, "parameter"],
  ] as const;
  const words = counts.filter(([count]) => count > 0).map(([count, word]) => plural(count, word));
  return make(
    "a",
    { class: "link-row", href: addressOf(ref) },
    make("span", { class: "row-name" }, name),
    make("span", { class: "type" }, componentType(profile)),
    make("span", { class: "hint" }, words.join(", ")),
  );
}

function emptyEngine(): HTMLElement {
  return make(
    "p",
    { class: "empty-state" },
    drawing("engine"),
    make("strong", {}, "There are no components here yet"),
    make("span", {}, "As soon as an adapter connects, they appear by themselves."),
  );
}

function plural(count: number, word: string): string {
  if (count === 1) return `1 ${word}`;
  return `${count} ${word.endsWith("y") ? `${word.slice(0, -1)}ie` : word}s`;
}
