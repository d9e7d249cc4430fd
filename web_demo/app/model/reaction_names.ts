/** Names and pictures for reactions. The numbers are those of the standard's Annex D; unknown ones keep their code. */

import { BODY, UNKNOWN } from "./reaction_icons.ts";

export interface ReactionLook {
  /** The last part of the identifier: `1` of `urn:x-rois:def:reaction:OMG::1`. */
  readonly code: string;
  readonly name: string;
  /** Data of an SVG path, 24 x 24 units. */
  readonly path: string;
}

const ANNEX_D: ReadonlyMap<string, string> = new Map(
  Object.entries({
    "1": "nod",
    "2": "tilt",
    "3": "shake_head",
    "9": "bow",
    "10": "shake_hands",
    "50": "glance_at_watch",
  }),
);

const NAMES: ReadonlyMap<string, string> = new Map(
  Object.entries({
    nod: "Nod",
    tilt: "Tilt head",
    shake_head: "Shake head",
    bow: "Bow",
    wave: "Wave",
    look_around: "Look around",
    shrug: "Shrug",
    clap: "Clap",
    raise_hand: "Raise hand",
    surprise: "Surprise",
    shake_hands: "Shake hands",
    glance_at_watch: "Check watch",
  }),
);

/** Returns how a reaction is shown. */
export function reactionLook(reactionRef: string): ReactionLook {
  const code = reactionRef.split(":").at(-1) ?? reactionRef;
  const key = ANNEX_D.get(code) ?? code;
  const spoken = key.replaceAll(/[_-]+/g, " ").trim();
  const name =
    NAMES.get(key) ?? (/^\d+$/.test(code) ? `Reaction ${code}` : capitalized(spoken || reactionRef));
  return { code, name, path: BODY.get(key) ?? UNKNOWN };
}

/** Returns the number of columns that leaves the fewest places empty; of equals, the one named first. */
export function bestColumns(count: number, candidates: readonly number[]): number {
  const empty = (columns: number): number => (columns - (count % columns)) % columns;
  return candidates.reduce((best, columns) => (empty(columns) < empty(best) ? columns : best));
}

function capitalized(text: string): string {
  return text.charAt(0).toUpperCase() + text.slice(1);
}
