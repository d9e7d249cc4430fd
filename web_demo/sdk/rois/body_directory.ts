/**
 * Bodies in a gateway's profile or directory: the engines that own components, and what each of them can do.
 *
 * A body is an engine that owns components: it lists some that no engine below it lists. What is reachable through it
 * belongs to it, too. Behind the main engine stand all bodies, so that of those it has only what it owns itself: a body is
 * never put together from two robots.
 */

import type { Profile } from "./client.ts";
import { codeOf, componentUrn } from "./discovery.ts";
import type { ComponentFunction, EngineEntry, HRIEngineProfile } from "./generated/types.ts";

/** A component of a body. */
export interface BodyComponent {
  readonly componentRef: string;
  /** The URN of its type. */
  readonly componentType: string;
  /**
   * No application holds it; null where the gateway does not tell. What needs no reservation is free.
   */
  readonly free: boolean | null;
}

/** A body: what it can do, and whether it is free. */
export interface BodyInfo {
  /** The engine, which leads the references of its components. */
  readonly engineId: string;
  /** Sorted by reference. */
  readonly components: readonly BodyComponent[];
  /** No application holds any part of it; null where the gateway does not tell. */
  readonly free: boolean | null;
}

/** A component of a body, as a profile or an entry of the directory describes it. */
export interface BodyPart {
  /** The URN of its type. */
  readonly componentType: string;
  /** Null where it is not said. */
  readonly function: ComponentFunction | null;
}

/** A body as the profile or the directory describes it. */
export interface BodyProfile {
  readonly engineId: string;
  /** Its components by their references, in sorted order. */
  readonly components: ReadonlyMap<string, BodyPart>;
}

/** Returns the bodies in the order of their ids, inner engines before those around them. */
export function bodiesIn({ profile, component_profiles: components }: Profile): BodyProfile[] {
  if (profile === null) return [];
  const bodyOf = (engine: HRIEngineProfile, refs: readonly string[]): BodyProfile =>
    body(
      engine.identifier.code,
      refs.flatMap((ref): [string, BodyPart][] => {
        const component = components[ref];
        if (component === undefined) return [];
        return [[ref, { componentType: componentUrn(component), function: component.function ?? null }]];
      }),
    );
  const below = ({ sub_profiles: engines = [] }: HRIEngineProfile): BodyProfile[] =>
    sorted(engines, ({ identifier }) => identifier.code).flatMap((engine) => {
      const ownsSome = ownRefs(engine).some((ref) => ref in components);
      return [...below(engine), ...(ownsSome ? [bodyOf(engine, reachable(engine))] : [])];
    });
  const main = bodyOf(profile, ownRefs(profile));
  return [...below(profile), ...(main.components.size > 0 ? [main] : [])];
}

/** Returns the bodies of a directory in the order of their ids, inner engines before those around them. */
export function bodiesOf(entries: ReadonlyMap<string, EngineEntry>): BodyProfile[] {
  const engines = new Map<string, EngineEntry[]>();
  for (const entry of sorted([...entries.values()], ({ engine_id }) => engine_id)) {
    const siblings = engines.get(entry.parent_id);
    if (siblings) siblings.push(entry);
    else engines.set(entry.parent_id, [entry]);
  }
  const found: BodyProfile[] = [];
  /** Adds the bodies of an engine and of those below it, and returns all their components. */
  const add = (engine: EngineEntry): [string, BodyPart][] => {
    const inner = (engines.get(engine.engine_id) ?? []).flatMap(add);
    const parts = [...ownParts(engine), ...inner];
    if (engine.components?.length) found.push(body(engine.engine_id, parts));
    return parts;
  };
  for (const main of engines.get("") ?? []) {
    for (const engine of engines.get(main.engine_id) ?? []) add(engine);
    if (main.components?.length) found.push(body(main.engine_id, ownParts(main)));
  }
  return found;
}

/** Returns what a body can do in one line: `Navigation, Reaction`. */
export function abilities({ components }: BodyProfile): string {
  return [...new Set([...components.values()].map((part) => codeOf(part.componentType)))].sort().join(", ");
}

/** Returns the references of the components of a type, in sorted order. */
export function refsOf({ components }: BodyProfile, urn: string): string[] {
  return [...components].flatMap(([ref, { componentType }]) => (componentType === urn ? [ref] : []));
}

function body(engineId: string, parts: readonly (readonly [string, BodyPart])[]): BodyProfile {
  return { engineId, components: new Map(sorted(parts, ([ref]) => ref)) };
}

function ownParts({ components = [] }: EngineEntry): [string, BodyPart][] {
  return components.map(({ component_ref, component_type, function: kind = null }) => [
    component_ref,
    { componentType: component_type, function: kind },
  ]);
}

function sorted<T>(values: readonly T[], key: (value: T) => string): T[] {
  return [...values].sort((one, other) => (key(one) < key(other) ? -1 : 1));
}

function reachable({ component_ids: refs = [], sub_profiles: engines = [] }: HRIEngineProfile): string[] {
  return [...refs, ...engines.flatMap(reachable)];
}

function ownRefs({ component_ids: refs = [], sub_profiles: engines = [] }: HRIEngineProfile): string[] {
  const below = new Set(engines.flatMap(reachable));
  return refs.filter((ref) => !below.has(ref));
}
