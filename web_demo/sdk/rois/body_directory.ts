/**
 * Bodies in a gateway's profile: the engines that own components, and what each of them can do.
 *
 * A body is an engine that owns components: it lists some that no engine below it lists. What is reachable through it
 * belongs to it, too. Behind the main engine stand all bodies, so that of those it has only what it owns itself: a body is
 * never put together from two robots.
 */

import type { Profile } from "./client.ts";
import { componentType, componentUrn } from "./discovery.ts";
import type { HRIComponentProfile, HRIEngineProfile } from "./generated/types.ts";

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

/** A body as the profile describes it. */
export interface BodyProfile {
  readonly engineId: string;
  /** The profiles of its components by their references, in sorted order. */
  readonly components: ReadonlyMap<string, HRIComponentProfile>;
}

/** Returns the bodies in the order of the profile, inner engines before those around them. */
export function bodiesIn({ profile, component_profiles: components }: Profile): BodyProfile[] {
  if (profile === null) return [];
  const bodyOf = (engineId: string, refs: Iterable<string>): BodyProfile => ({
    engineId,
    components: new Map(
      [...new Set(refs)].sort().flatMap((ref) => {
        const component = components[ref];
        return component ? [[ref, component]] : [];
      }),
    ),
  });
  const below = (engine: HRIEngineProfile): BodyProfile[] => {
    const inner = (engine.sub_profiles ?? []).flatMap(below);
    const ownsSome = ownRefs(engine).some((ref) => ref in components);
    return ownsSome ? [...inner, bodyOf(engine.identifier.code, reachable(engine))] : inner;
  };
  const main = bodyOf(profile.identifier.code, ownRefs(profile));
  return [...(profile.sub_profiles ?? []).flatMap(below), ...(main.components.size > 0 ? [main] : [])];
}

/** Returns what a body can do in one line: `Navigation, Reaction`. */
export function abilities({ components }: BodyProfile): string {
  return [...new Set([...components.values()].map(componentType))].sort().join(", ");
}

/** Returns the references of the components of a type, in sorted order. */
export function refsOf({ components }: BodyProfile, urn: string): string[] {
  return [...components].flatMap(([ref, profile]) => (componentUrn(profile) === urn ? [ref] : []));
}

function reachable({ component_ids: refs = [], sub_profiles: engines = [] }: HRIEngineProfile): string[] {
  return [...refs, ...engines.flatMap(reachable)];
}

function ownRefs({ component_ids: refs = [], sub_profiles: engines = [] }: HRIEngineProfile): string[] {
  const below = new Set(engines.flatMap(reachable));
  return refs.filter((ref) => !below.has(ref));
}
