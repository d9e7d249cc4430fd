/** What there is as a tree of engines and components, and the rows of it that are shown. Pure. */

import { componentType, componentUrn, engineOf } from "../../sdk/index.ts";
import type { HRIComponentProfile, HRIEngineProfile, Profile } from "../../sdk/index.ts";

export interface ComponentNode {
  readonly ref: string;
  /** The ref without its engine. */
  readonly name: string;
  readonly profile: HRIComponentProfile;
  /** The profile is loaded; else it has the type alone. */
  readonly isLoaded: boolean;
  /** What a search looks at: the refs and names that the profile holds, the most telling first. */
  readonly terms: readonly string[];
}

export interface EngineNode {
  readonly id: string;
  /** Null for an engine whose profile is not loaded, or that is known by its components alone. */
  readonly profile: HRIEngineProfile | null;
  readonly components: readonly ComponentNode[];
  readonly engines: readonly EngineNode[];
}

export interface Row {
  /** An engine's id or a component's ref: only a ref has a slash. */
  readonly id: string;
  readonly label: string;
  /** 1 for the top. */
  readonly level: number;
  /** Null for a component, which holds nothing. */
  readonly expanded: boolean | null;
  /** Of an engine: how many components it and the engines below it have. */
  readonly count: number;
  readonly component: ComponentNode | null;
  /** The name inside the component by which the search found it; empty if its own name says why. */
  readonly found: string;
}

/** Returns the references of all components that an engine or one below it lists. */
function reachable({ component_ids = [], sub_profiles = [] }: HRIEngineProfile): string[] {
  return [...component_ids, ...sub_profiles.flatMap(reachable)];
}

/** Returns the engines at the top: the gateway's own, and behind it those that no profile lists. */
export function engineTree({ profile, component_profiles }: Profile): EngineNode[] {
  const listed = new Set<string>();
  const component = (ref: string): ComponentNode => {
    listed.add(ref);
    return componentNode(ref, component_profiles[ref] ?? { identifier: { code: "" }, name: "" });
  };
  const engine = (each: HRIEngineProfile): EngineNode => {
    const { component_ids = [], sub_profiles = [] } = each;
    const below = new Set(sub_profiles.flatMap(reachable));
    return {
      id: each.identifier.code,
      profile: each,
      components: component_ids.filter((ref) => !below.has(ref)).map(component),
      engines: sub_profiles.map(engine),
    };
  };
  const top = profile === null ? [] : [engine(profile)];
  const strays = Object.keys(component_profiles).filter((ref) => !listed.has(ref));
  const engines = [...new Set(strays.map(engineOf))].map((id) => ({
    id,
    profile: null,
    components: strays.filter((ref) => engineOf(ref) === id).map(component),
    engines: [],
  }));
  return [...top, ...engines];
}

export function componentNode(ref: string, profile: HRIComponentProfile, isLoaded = true): ComponentNode {
  const { command_profiles = [], query_profiles = [], event_profiles = [] } = profile;
  const messages = [...command_profiles, ...query_profiles, ...event_profiles];
  const inside = [
    ...messages.map(({ name }) => name),
    ...(profile.parameter_profiles ?? []).map(({ name }) => name),
    ...command_profiles.flatMap((each) => (each.arguments ?? []).map(({ name }) => name)),
    ...messages.flatMap((each) => (each.results ?? []).map(({ name }) => name)),
  ];
  const terms = [ref, componentType(profile), componentUrn(profile), profile.function ?? "", ...inside];
  return { ref, name: ref.slice(ref.indexOf("/") + 1), profile, isLoaded, terms };
}

/** Returns every component of the tree, in the order in which it is shown. */
export function componentsOf(engines: readonly EngineNode[]): ComponentNode[] {
  return engines.flatMap((engine) => [...engine.components, ...componentsOf(engine.engines)]);
}

/** Returns every engine of the tree, each before those below it. */
export function enginesOf(engines: readonly EngineNode[]): EngineNode[] {
  return engines.flatMap((engine) => [engine, ...enginesOf(engine.engines)]);
}

/**
 * Returns the rows that are shown, from top to bottom.
 *
 * @param isExpanded whether an engine shows what it holds, while nothing is searched
 * @param search every word has to be in the component or in an engine that it stands under
 */
export function visibleRows(
  engines: readonly EngineNode[],
  isExpanded: (engineId: string) => boolean,
  search = "",
): Row[] {
  const words = search.toLowerCase().split(/\s+/).filter(Boolean);
  return engines.flatMap((engine) => engineRows(engine, 1, isExpanded, words));
}

function engineRows(
  engine: EngineNode,
  level: number,
  isExpanded: (engineId: string) => boolean,
  words: readonly string[],
): Row[] {
  const searching = words.length > 0;
  // Words that are in the engine's own name are met by all that it holds.
  const left = words.filter((word) => !engine.id.toLowerCase().includes(word));
  const expanded = searching || isExpanded(engine.id);
  const components = engine.components.flatMap((each) => componentRow(each, level + 1, left));
  const below = engine.engines.flatMap((each) => engineRows(each, level + 1, isExpanded, left));
  if (searching && left.length > 0 && components.length + below.length === 0) return [];
  const count = componentsOf([engine]).length;
  const row = { id: engine.id, label: engine.id, level, expanded, count, component: null, found: "" };
  return expanded ? [row, ...components, ...below] : [row];
}

function componentRow(component: ComponentNode, level: number, words: readonly string[]): Row[] {
  const found = words.map((word) => component.terms.find((term) => term.toLowerCase().includes(word)));
  if (found.includes(undefined)) return [];
  const inside = found.find((term) => component.terms.indexOf(term ?? "") > 1) ?? "";
  const { ref: id, name: label } = component;
  return [{ id, label, level, expanded: null, count: 0, component, found: inside }];
}

/** Returns the query for a component's status: of those with a status among their results, the one with the fewest. */
export function statusQuery({ query_profiles = [] }: HRIComponentProfile): string | null {
  const telling = query_profiles.filter(({ results = [] }) =>
    results.some(({ data_type_ref: { code } }) => code.toLowerCase() === STATUS_TYPE),
  );
  telling.sort((one, other) => (one.results?.length ?? 0) - (other.results?.length ?? 0));
  return telling[0]?.name ?? null;
}

const STATUS_TYPE = "component_status";

/**
 * Returns the tree with what is looked at in it, even if that has left: an engine by its id, a component as it was.
 *
 * @param component of the id, if that is a component's and was known once
 */
export function withAway(
  engines: readonly EngineNode[],
  id: string,
  component: ComponentNode | null,
): readonly EngineNode[] {
  const there =
    enginesOf(engines).some((engine) => engine.id === id) ||
    componentsOf(engines).some(({ ref }) => ref === id);
  if (id === "" || there || (id.includes("/") && component === null)) return engines;
  const engineId = component === null ? id : engineOf(id);
  const components = component === null ? [] : [component];
  if (!enginesOf(engines).some((engine) => engine.id === engineId)) {
    return [...engines, { id: engineId, profile: null, components, engines: [] }];
  }
  const add = (engine: EngineNode): EngineNode => ({
    ...engine,
    components: engine.id === engineId ? [...engine.components, ...components] : engine.components,
    engines: engine.engines.map(add),
  });
  return engines.map(add);
}
