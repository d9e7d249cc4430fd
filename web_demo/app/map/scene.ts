/** What is on the floor, out of what the avatar tells. Pure. */

import type { Things } from "../model/own_components.ts";
import { readPlace } from "./geometry.ts";
import type { Place } from "./geometry.ts";

export interface Thing {
  readonly ref: string;
  readonly kind: "person" | "sound" | "object";
  readonly name: string;
  readonly place: Place;
}

/** What cannot be read is left out; a thing without a name is called by the last part of its ref. */
export function readThings({ thing_ref: refs, kind, name, position_data: places }: Things): Thing[] {
  return refs.flatMap((ref, index) => {
    const place = readPlace(places[index] ?? "");
    if (place === null) return [];
    const told = kind[index];
    return {
      ref,
      kind: told === "person" || told === "sound" ? told : "object",
      name: name[index] || (ref.split("/").at(-1) ?? ref),
      place,
    };
  });
}

/** Returns what is still ahead once a target was reached: what stands before it was passed. */
export function ahead<T extends { readonly text: string }>(
  targets: readonly T[],
  reached: string,
): readonly T[] {
  return targets.slice(targets.findIndex(({ text }) => text === reached) + 1);
}
