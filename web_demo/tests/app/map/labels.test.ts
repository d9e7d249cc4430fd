import { describe, expect, it } from "vitest";
import type { Extent, Thing } from "../../../app/map/geometry.ts";
import { placeLabels } from "../../../app/map/labels.ts";
import type { Label } from "../../../app/map/labels.ts";

const FLOOR: Extent = { left: -5, top: -4, width: 10, height: 8 };
const LETTERS = 0.38;

function thing(name: string, x: number, y: number, kind: Thing["kind"] = "object"): Thing {
  return { ref: name, name, kind, place: { x, y, th: 0 } };
}

/** The corners of a name in the drawing: left, top, right, bottom. */
function cornersOf({ name, place }: Thing, { x, y }: Label): [number, number, number, number] {
  const half = ([...name].length * 0.58 * LETTERS) / 2;
  const [middle, line] = [place.x + x, -place.y + y];
  return [middle - half, line - 0.8 * LETTERS, middle + half, line + 0.25 * LETTERS];
}

function placed(things: readonly Thing[]): Map<string, [number, number, number, number]> {
  const labels = placeLabels(things, FLOOR, LETTERS);
  return new Map(things.map((each) => [each.name, cornersOf(each, labels.get(each.ref) as Label)]));
}

function pairs<T>(all: readonly T[]): [T, T][] {
  return all.flatMap((one, index) => all.slice(index + 1).map((other): [T, T] => [one, other]));
}

const overlap = (
  [left, top, right, bottom]: readonly number[],
  [left2, top2, right2, bottom2]: readonly number[],
): boolean =>
  Math.min(right as number, right2 as number) - Math.max(left as number, left2 as number) > 1e-9 &&
  Math.min(bottom as number, bottom2 as number) - Math.max(top as number, top2 as number) > 1e-9;

/** As in the rooms of the simulated robot. */
const ROOMS = [
  thing("reader", -1.1, 1.9, "person"),
  thing("cook", 1.5, 2.45, "person"),
  thing("clerk", 2.7, -2.2, "person"),
  thing("bookshelf", -2.6, 3.2),
  thing("lamp", -4.6, 3.1),
  thing("sofa", -4.4, 1.6),
  thing("coffee table", -2.9, 1.7),
  thing("plant", -0.5, 3),
  thing("counter", 2.6, 3.3),
  thing("fridge", 4.6, 3.2),
  thing("kitchen table", 3.4, 1.5),
  thing("desk", 4.4, -1.2),
  thing("cupboard", 1.3, -3.6),
  thing("dock", -4, -2.5),
];

describe("names on the map", () => {
  it("stand below their things where there is room", () => {
    const label = placeLabels([thing("plant", 0, 0)], FLOOR, LETTERS).get("plant");
    expect(label?.x).toBe(0);
    expect(label?.y).toBeCloseTo(0.19 + 0.88 * LETTERS);
  });

  it("do not stand on each other, nor on persons, in rooms full of things", () => {
    const boxes = placed(ROOMS);
    for (const [one, other] of pairs([...boxes]))
      expect(overlap(one[1], other[1]), `${one[0]}, ${other[0]}`).toBe(false);
    for (const { place, kind, name: person } of ROOMS) {
      if (kind !== "person") continue;
      const mark = [place.x - 0.19, -place.y - 0.19, place.x + 0.19, -place.y + 0.19];
      for (const [name, box] of boxes) expect(overlap(box, mark), `${name} on ${person}`).toBe(false);
    }
  });

  it("stay within the drawing", () => {
    for (const [x, y] of [
      [-5, 4],
      [5, 4],
      [-5, -4],
      [5, -4],
    ] as const) {
      const [left, top, right, bottom] = placed([thing("a long name", x, y)]).get("a long name") ?? [];
      expect(left).toBeGreaterThanOrEqual(-5 - 1e-9);
      expect(right).toBeLessThanOrEqual(5 + 1e-9);
      expect(top).toBeGreaterThanOrEqual(-4 - 1e-9);
      expect(bottom).toBeLessThanOrEqual(4 + 1e-9);
    }
    const [left, , right] = placed([thing("w".repeat(60), 3, 0)]).get("w".repeat(60)) ?? [];
    expect(((left as number) + (right as number)) / 2, "too long for any place").toBeCloseTo(0);
  });

  it("stay on their side while they can be read, and change it when another comes there", () => {
    const [table, guest] = [thing("table", 0, 0), thing("guest", 0, 0.2, "person")];
    const near = placeLabels([table, guest], FLOOR, LETTERS);
    expect(near.get("guest")?.side).not.toBe(0);
    const gone = { ...guest, place: { x: 3, y: 0.2, th: 0 } };
    const far = placeLabels([table, gone], FLOOR, LETTERS, near);
    expect(far.get("guest")?.side, "it has room below, too").toBe(near.get("guest")?.side);
    const back = placeLabels([table, guest], FLOOR, LETTERS, placeLabels([table, gone], FLOOR, LETTERS));
    expect(back.get("guest")?.side).not.toBe(0);
    expect(back.get("table")?.side, "what stands still keeps its name where it is").toBe(0);
  });

  it("cover least where there is no room for all", () => {
    const crowd = Array.from({ length: 8 }, (_, index) => thing(`number ${index}`, 0, 0));
    const labels = placeLabels(crowd, FLOOR, LETTERS);
    expect(new Set([...labels.values()].map(({ side }) => side)).size).toBe(4);
  });
});
