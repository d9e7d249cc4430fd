/** Where the faces that the avatar sees are drawn over the preview, and what stands beside them. Pure. */

import type { Seen } from "../model/own_components.ts";

/** In shares of a picture, from its left top corner. */
export interface Box {
  readonly left: number;
  readonly top: number;
  readonly width: number;
  readonly height: number;
}

export interface Face {
  readonly ref: string;
  readonly box: Box;
  readonly name: string;
  /** What the head is doing, in words; empty for nothing. */
  readonly gesture: string;
}

/** Milliseconds for which a gesture stands beside a face: it is reported once, when it is complete. */
const GESTURE_SHOWN = 2000;
const GESTURES: Readonly<Record<string, string>> = {
  "1": "nods",
  "2": "tilts the head",
  "3": "shakes the head",
};

/** Reads `left,top,width,height`; null where it is not that. */
export function readBox(text: string): Box | null {
  const numbers = text.split(",").map((part) => (part.trim() === "" ? Number.NaN : Number(part)));
  const [left = 0, top = 0, width = 0, height = 0] = numbers;
  if (numbers.length !== 4 || !numbers.every(Number.isFinite) || width <= 0 || height <= 0) return null;
  return { left, top, width, height };
}

/**
 * Returns where a box is in a preview that shows the middle of a picture as in a mirror.
 *
 * @param picture,preview widths by heights; of a picture of another shape the edges are cut off
 */
export function inMirror({ left, top, width, height }: Box, picture: number, preview: number): Box {
  const wide = Math.max(1, picture / preview);
  const high = Math.max(1, preview / picture);
  return {
    left: (1 - left - width - 0.5) * wide + 0.5,
    top: (top - 0.5) * high + 0.5,
    width: width * wide,
    height: height * high,
  };
}

/** Returns a gesture as a verb, such as `nods`. */
export function gestureWords(gestureRef: string): string {
  if (gestureRef === "") return "";
  const code = gestureRef.split(":").at(-1) ?? "";
  return GESTURES[code] ?? code.replaceAll("_", " ");
}

/** The faces of the last picture, with the gestures of the last two seconds. */
export class Faces {
  readonly #gestures = new Map<string, { readonly words: string; readonly until: number }>();

  /** @param now milliseconds of any clock */
  see({ person_ref: refs, box, name, gesture_ref: gestures }: Seen, now: number): Face[] {
    for (const [ref, { until }] of this.#gestures) if (until <= now) this.#gestures.delete(ref);
    return refs.flatMap((ref, index) => {
      const words = gestureWords(gestures[index] ?? "");
      if (words !== "") this.#gestures.set(ref, { words, until: now + GESTURE_SHOWN });
      const place = readBox(box[index] ?? "");
      if (place === null) return [];
      return { ref, box: place, name: name[index] ?? "", gesture: this.#gestures.get(ref)?.words ?? "" };
    });
  }
}
