/**
 * Where the names of things stand on the floor map: beside their marks, within the drawing, and not on each other.
 * In coordinates of the drawing: metres, y downwards. Pure.
 */

import type { Extent, Thing } from "./geometry.ts";

/** The middle of a name's base line, as seen from its thing, and which side of it that is. */
export interface Label {
  readonly x: number;
  readonly y: number;
  readonly side: number;
}

interface Box {
  readonly left: number;
  readonly top: number;
  readonly right: number;
  readonly bottom: number;
}

/** Radii of the marks, in metres. Objects have none, but their name is not in their middle, where bodies dock. */
const RADII = { person: 0.19, sound: 0.28, object: 0.19 } as const;
/** In heights of letters: the width of one on average, what is above the base line and below, and the gap to a mark. */
const [WIDE, ABOVE, BELOW, GAP] = [0.58, 0.8, 0.25, 0.08];
/** How bad it is to cover a mark, beside a name, which cannot be read then. */
const MARK = 0.5;

/**
 * Returns a label for each thing, by its ref.
 *
 * @param letters the height of letters
 * @param former what was returned before: a name stays on its side while it can be read, although things move
 */
export function placeLabels(
  things: readonly Thing[],
  extent: Extent,
  letters: number,
  former: ReadonlyMap<string, Label> = new Map(),
): Map<string, Label> {
  const marks = things.filter(({ kind }) => kind !== "object").map(boxOfMark);
  const taken: Box[] = [];
  const labels = new Map<string, Label>();
  // Objects stand still: the names of persons make way for theirs.
  const ordered = [
    ...things.filter(({ kind }) => kind === "object"),
    ...things.filter(({ kind }) => kind !== "object"),
  ];
  for (const thing of ordered) {
    const choices = sides(thing, extent, letters);
    const kept = choices[former.get(thing.ref)?.side ?? -1];
    const best = kept && covered(kept.box, taken) === 0 ? kept : least(choices, taken, marks);
    taken.push(best.box);
    labels.set(thing.ref, best.label);
  }
  return labels;
}

interface Choice {
  readonly label: Label;
  readonly box: Box;
}

/** A name below its thing, above it, to the right and to the left; moved into the drawing. */
function sides({ name, kind, place }: Thing, extent: Extent, letters: number): Choice[] {
  const [x, y] = [place.x, -place.y];
  const half = ([...name].length * WIDE * letters) / 2;
  const away = RADII[kind] + GAP * letters;
  const level = ((ABOVE - BELOW) * letters) / 2;
  return [
    [0, away + ABOVE * letters],
    [0, -away - BELOW * letters],
    [away + half, level],
    [-away - half, level],
  ].map(([right = 0, down = 0], side) => {
    const middle = within(x + right, extent.left + half, extent.left + extent.width - half);
    const line = within(y + down, extent.top + ABOVE * letters, extent.top + extent.height - BELOW * letters);
    const box = {
      left: middle - half,
      top: line - ABOVE * letters,
      right: middle + half,
      bottom: line + BELOW * letters,
    };
    return { label: { x: middle - x, y: line - y, side }, box };
  });
}

/** The first choice that covers least. */
function least(choices: readonly Choice[], taken: readonly Box[], marks: readonly Box[]): Choice {
  const costs = choices.map(({ box }) => covered(box, taken) + MARK * covered(box, marks));
  return choices[costs.indexOf(Math.min(...costs))] as Choice;
}

function boxOfMark({ kind, place: { x, y } }: Thing): Box {
  const radius = RADII[kind];
  return { left: x - radius, top: -y - radius, right: x + radius, bottom: -y + radius };
}

/** The area of a box that others cover. */
function covered(box: Box, others: readonly Box[]): number {
  return others.reduce((sum, other) => {
    const wide = Math.min(box.right, other.right) - Math.max(box.left, other.left);
    const high = Math.min(box.bottom, other.bottom) - Math.max(box.top, other.top);
    return wide > 0 && high > 0 ? sum + wide * high : sum;
  }, 0);
}

/** A value between two ends; in their middle where they have changed places. */
function within(value: number, low: number, high: number): number {
  return low > high ? (low + high) / 2 : Math.min(high, Math.max(low, value));
}
