/** Names and pictures for reactions. The numbers are those of the standard's Annex D; unknown ones keep their code. */

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

/** Line icons of our own: the data of one path each, 24 x 24 units. */

const HEAD = "M12 4.5a4.2 4.2 0 1 0 0 8.4 4.2 4.2 0 0 0 0-8.4Z";
const SHOULDERS = "M4.5 20c.6-3.6 3.6-5.3 7.5-5.3s6.9 1.7 7.5 5.3";

const ICONS: ReadonlyMap<string, string> = new Map(
  Object.entries({
    nod: "M10 4.5a4.2 4.2 0 1 0 0 8.4 4.2 4.2 0 0 0 0-8.4ZM3 20c.6-3.4 3.3-5.1 7-5.1s6.4 1.7 7 5.1M19 4v9.5M16.8 11.3l2.2 2.2 2.2-2.2M16.8 6.2 19 4l2.2 2.2",
    tilt: "M9.7 5.5a4.2 4.2 0 1 0 5 6.7 4.2 4.2 0 0 0-5-6.7ZM4.5 20.5c.6-3 3.3-4.7 7.1-4.7s6.9 1.7 7.5 4.7M15.5 3.5c2.7.5 4.5 2.3 5 5M20.9 5.6l-.4 2.9-2.7-1",
    shake_head: `${HEAD}${SHOULDERS}M5.2 6.5 2.8 8.7l2.4 2.2M18.8 6.5l2.4 2.2-2.4 2.2`,
    bow: "M5.4 8.2a2.7 2.7 0 1 0 0 5.4 2.7 2.7 0 0 0 0-5.4ZM8.3 9.6c1.7-2 4-2.9 6-2.4 2.5.6 3.7 2.4 3.7 5.3v8M14.6 20.5v-7.3M9.2 12.6l-.6 5.2",
    wave: "M8.2 13.5V6.8a1.4 1.4 0 0 1 2.8 0V12M11 11.5V5a1.4 1.4 0 0 1 2.8 0v6.5M13.8 11.5V6.3a1.4 1.4 0 0 1 2.8 0v7.2c0 4.2-2 7-5.3 7-2.6 0-3.9-1.2-5.3-3.6l-1.6-2.7c-.9-1.6 1.1-2.9 2.3-1.6l1.5 1.7M18.6 3.3c1 .8 1.7 1.8 2 3M4.8 3.9c-.9.8-1.5 1.7-1.8 2.8",
    look_around:
      "M2.8 12c2.4-4 5.5-6 9.2-6s6.8 2 9.2 6c-2.4 4-5.5 6-9.2 6s-6.8-2-9.2-6ZM12 9.3a2.7 2.7 0 1 0 0 5.4 2.7 2.7 0 0 0 0-5.4Z",
    shrug:
      "M12 3.5a3.5 3.5 0 1 0 0 7 3.5 3.5 0 0 0 0-7ZM8 20.5v-5.2c-1.8.4-3 .2-4.6-2.8l-.9-1.7M16 20.5v-5.2c1.8.4 3 .2 4.6-2.8l.9-1.7M8 15.3c.6-1.5 2-2.3 4-2.3s3.4.8 4 2.3",
    clap: "M5 12.8 9.8 8a1.5 1.5 0 0 1 2.1 2.1L9 13M9.5 12.5l4.3-4.3a1.5 1.5 0 0 1 2.1 2.1l-3.6 3.6M13.5 12.7l2.6-2.6a1.5 1.5 0 0 1 2.1 2.1l-5.9 5.9c-2.6 2.6-6 2.6-8 .6s-1.7-3.6.7-5.9M12.5 2.8v2.4M17 3.8l-1.2 2M20.3 7.3l-2.1 1",
    raise_hand:
      "M9.5 4.6a3.5 3.5 0 1 0 0 7 3.5 3.5 0 0 0 0-7ZM2.8 20.5c.4-3.7 2.9-5.7 6.7-5.7 2 0 3.7.6 4.9 1.7l2-2.5V4.9a1.7 1.7 0 0 1 3.4 0v9.6c0 1.3-.3 2.2-1 3.2l-2 2.8",
    surprise:
      "M12 3.2a8.8 8.8 0 1 0 0 17.6 8.8 8.8 0 0 0 0-17.6ZM12 13.3a2 2.3 0 1 0 0 4.6 2 2.3 0 0 0 0-4.6ZM9 10.3h.01M15 10.3h.01M7.6 7.2c.6-.7 1.4-1 2.4-.9M16.4 7.2c-.6-.7-1.4-1-2.4-.9",
    shake_hands:
      "M2.5 8 6 6.5l5 1.2-3 3.2c1.2 1.5 2.8 1.5 4.2.1l1.3-1.2 4.7 4.4c.9.9-.3 2.3-1.4 1.5M15.3 17.3c1 .8 2.3-.5 1.5-1.6M13.4 18.8c.9.7 2.3-.5 1.9-1.5M11.3 19.6c.8.7 2.1-.1 2.1-.8M8.5 17.4l2.8 2.2M4.5 14.5l4 2.9M11 7.7l3-1.2 4 1.5 3.5-.5M2.5 14.5h2M18.5 14.2h3",
    glance_at_watch:
      "M12 7a5 5 0 1 0 0 10 5 5 0 0 0 0-10ZM12 9.8V12l1.6 1.2M9.3 7.3 9.9 3.5h4.2l.6 3.8M9.3 16.7l.6 3.8h4.2l.6-3.8",
  }),
);

const UNKNOWN_ICON =
  "M12 3.5l1.9 5.6 5.6 1.9-5.6 1.9L12 18.5l-1.9-5.6L4.5 11l5.6-1.9ZM18.5 16.5v4M16.5 18.5h4";

/** Returns how a reaction is shown. */
export function reactionLook(reactionRef: string): ReactionLook {
  const code = reactionRef.split(":").at(-1) ?? reactionRef;
  const key = ANNEX_D.get(code) ?? code;
  const spoken = key.replaceAll(/[_-]+/g, " ").trim();
  const name =
    NAMES.get(key) ?? (/^\d+$/.test(code) ? `Reaction ${code}` : capitalized(spoken || reactionRef));
  return { code, name, path: ICONS.get(key) ?? UNKNOWN_ICON };
}

/** Returns the number of columns that leaves the fewest places empty; of equals, the one named first. */
export function bestColumns(count: number, candidates: readonly number[]): number {
  const empty = (columns: number): number => (columns - (count % columns)) % columns;
  return candidates.reduce((best, columns) => (empty(columns) < empty(best) ? columns : best));
}

function capitalized(text: string): string {
  return text.charAt(0).toUpperCase() + text.slice(1);
}
