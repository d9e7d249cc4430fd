/**
 * Places and things on the floor, and where they are drawn. In the scene x is to the right and y away from the viewer,
 * in metres; in the drawing y is downwards. Pure.
 */

import type { Things } from "../model/own_components.ts";

export type Point = readonly [x: number, y: number];

/** Metres, and radians counter-clockwise from the x axis. */
export interface Place {
  readonly x: number;
  readonly y: number;
  readonly th: number;
}

/** Where a figure begins: in front, facing the viewer. Every engine's floor has it there. */
export const HOME: Place = { x: 0, y: 0, th: -Math.PI / 2 };
/** Metres and radians from `HOME` within which a figure counts as being there. */
const NEAR_HOME = { metres: 0.2, radians: 0.4 };

/** Metres from the middle of a dock within which a body counts as being on it. */
const NEAR_DOCK = 0.35;

/** What of the drawing is shown, in its own coordinates. */
export interface Extent {
  readonly left: number;
  readonly top: number;
  readonly width: number;
  readonly height: number;
}

/** Metres around the floor, so that its edge is seen. */
const MARGIN = 0.2;
/** Metres that are shown around what there is, where there is no floor. */
const AROUND = 2;
/** How far an arrow key moves the cursor, in metres, and with Shift. */
const STEP = 0.25;
const LARGE_STEP = 1;
const STEPS: Readonly<Record<string, Point>> = {
  ArrowLeft: [-1, 0],
  ArrowRight: [1, 0],
  ArrowUp: [0, 1],
  ArrowDown: [0, -1],
};

/** Reads `x,y` or `x,y,th`; null where it is neither. */
export function readPlace(text: string): Place | null {
  const numbers = text.split(",").map((part) => (part.trim() === "" ? Number.NaN : Number(part)));
  const [x, y, th = 0] = numbers;
  if (numbers.length < 2 || numbers.length > 3 || !numbers.every(Number.isFinite)) return null;
  return { x: x ?? 0, y: y ?? 0, th };
}

export function readCorners(texts: readonly string[]): Point[] {
  return texts.map(readPlace).flatMap((place) => (place ? [[place.x, place.y] as const] : []));
}

/** @param others what is to be seen where there is no floor; at least one of them */
export function extentOf(outline: readonly Point[], others: readonly Point[]): Extent {
  const [corners, margin] = outline.length > 0 ? [outline, MARGIN] : [others, AROUND];
  const [xs, ys] = [corners.map(([x]) => x), corners.map(([, y]) => -y)];
  const left = Math.min(...xs) - margin;
  const top = Math.min(...ys) - margin;
  return { left, top, width: Math.max(...xs) + margin - left, height: Math.max(...ys) + margin - top };
}

/** Returns corners as an SVG has them. */
export function drawn(corners: readonly Point[]): string {
  return corners.map(([x, y]) => `${x},${-y}`).join(" ");
}

/** Returns lines that are a metre apart, as the data of an SVG path. */
export function gridLines({ left, top, width, height }: Extent): string {
  const lines = [];
  for (let x = Math.ceil(left); x <= left + width; x += 1) lines.push(`M${x} ${top}v${height}`);
  for (let y = Math.ceil(top); y <= top + height; y += 1) lines.push(`M${left} ${y}h${width}`);
  return lines.join("");
}

/** Where a key moves the cursor; null for keys that do not, and never out of what is shown. */
export function moved([x, y]: Point, key: string, far: boolean, extent: Extent): Point | null {
  const step = STEPS[key];
  if (!step) return null;
  const length = far ? LARGE_STEP : STEP;
  const within = (value: number, low: number, size: number): number =>
    Math.min(low + size, Math.max(low, value));
  return [
    within(x + length * step[0], extent.left, extent.width),
    -within(-(y + length * step[1]), extent.top, extent.height),
  ];
}

/** The nearest of those that are within reach, in metres. */
export function nearest<T extends { readonly place: Place }>(
  all: readonly T[],
  [x, y]: Point,
  reach: number,
): T | null {
  const far = ({ place }: T): number => Math.hypot(place.x - x, place.y - y);
  const within = all.filter((each) => far(each) <= reach);
  return within.sort((one, other) => far(one) - far(other))[0] ?? null;
}

/** Returns a point as RoIS has positions. */
export function positionText([x, y]: Point): string {
  return `${x.toFixed(2)},${y.toFixed(2)}`;
}

/** Returns a point as people read it. */
export function pointWords([x, y]: Point): string {
  return [x, y].map((value) => (value.toFixed(1) === "-0.0" ? "0.0" : value.toFixed(1))).join(", ");
}

/** Returns the thing at which a body is charged, if its floor has one: it is at home there. */
export function findDock(things: readonly Thing[]): Thing | null {
  return things.find(({ kind, name }) => kind === "object" && name === "dock") ?? null;
}

/** Whether a body has left its dock; without one, whether it has left where figures begin, or faces elsewhere. */
export function isAway({ x, y, th }: Place, dock: Thing | null = null): boolean {
  if (dock) return Math.hypot(x - dock.place.x, y - dock.place.y) > NEAR_DOCK;
  const aside = Math.abs(Math.atan2(Math.sin(th - HOME.th), Math.cos(th - HOME.th)));
  return Math.hypot(x - HOME.x, y - HOME.y) > NEAR_HOME.metres || aside > NEAR_HOME.radians;
}

/** Degrees by which something that points to the right is turned to face `th`. */
export function turned(th: number): number {
  return (-th * 180) / Math.PI;
}

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
    const described = kind[index];
    return {
      ref,
      kind: described === "person" || described === "sound" ? described : "object",
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
