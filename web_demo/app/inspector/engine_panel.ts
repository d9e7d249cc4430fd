/** An engine: what is in it, what it says of itself, and the errors that it notified. */

import { componentType } from "../../sdk/index.ts";
import type { ParameterProfile } from "../../sdk/index.ts";
import { make, setText } from "../dom/elements.ts";
import { button, disclosure, jsonBlock } from "./controls.ts";
import type { Fault } from "./fault_log.ts";
import { drawing } from "./icons.ts";
import { FaultGroup, Group, copyable } from "./panel_parts.ts";
import type { ComponentNode, EngineNode } from "./profile_tree.ts";
import { componentsOf, enginesOf } from "./profile_tree.ts";
import { addressOf } from "./routes.ts";

/** Rows of a list that are shown at once. */
const PAGE = 50;

export class EnginePanel {
  readonly element: HTMLElement;
  readonly #faults = new FaultGroup();
  /** How many rows of each list are shown. */
  readonly #shown: Map<string, number>;

  /** @param former what showed the engine until now; its lists are as long as they were there */
  constructor(engine: EngineNode, absent: string, former: EnginePanel | null) {
    this.#shown = new Map(former ? former.#shown : []);
    const { profile, components, engines, id } = engine;
    const parts = [engineHead(engine)];
    if (absent !== "") parts.push(make("p", { class: "absent", role: "status" }, absent));
    if (engines.length > 0) parts.push(this.#list("engines", "Engines", engines, engineLink));
    if (components.length > 0) parts.push(this.#list("components", "Components", components, componentLink));
    if (engines.length + components.length === 0 && absent === "") parts.push(emptyEngine());
    const parameters = profile?.parameter_profiles ?? [];
    if (parameters.length > 0) {
      parts.push(this.#list("engine-parameters", "Parameters", parameters, parameterRow));
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

  /** Makes a list of which a page is shown, and one more each time that it is wanted. */
  #list<T>(kind: string, title: string, items: readonly T[], row: (item: T) => HTMLElement): HTMLElement {
    const group = new Group(kind, title, kind === "engine-parameters" ? "parameter" : "engine");
    const more = button("", () => show(group.body.childElementCount - 1 + PAGE)?.focus());
    const show = (count: number): HTMLElement | undefined => {
      const rows = items.slice(group.body.childElementCount - 1, count).map(row);
      this.#shown.set(kind, count);
      more.before(...rows);
      more.hidden = items.length <= count;
      setText(more, `Show ${Math.min(PAGE, items.length - count)} more`);
      return rows[0];
    };
    group.body.append(more);
    show(this.#shown.get(kind) ?? PAGE);
    group.count = items.length;
    return group.element;
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

function parameterRow({ name, data_type_ref, default_value = "" }: ParameterProfile): HTMLElement {
  return make(
    "div",
    { class: "link-row" },
    make("span", { class: "row-name" }, name),
    make("span", { class: "type" }, data_type_ref.code),
    make("span", { class: "hint" }, default_value),
  );
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
