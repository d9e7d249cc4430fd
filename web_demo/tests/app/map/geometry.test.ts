import { describe, expect, it } from "vitest";
import {
  ahead,
  drawn,
  extentOf,
  gridLines,
  HOME,
  findDock,
  isAway,
  moved,
  nearest,
  pointWords,
  positionText,
  readCorners,
  readPlace,
  readThings,
  turned,
} from "../../../app/map/geometry.ts";

const ROOM = extentOf(
  [
    [-3, -1],
    [3, -1],
    [3, 4],
    [-3, 4],
  ],
  [],
);

describe("places", () => {
  it.each([
    ["1,2", { x: 1, y: 2, th: 0 }],
    ["-0.5,2.25,-1.5708", { x: -0.5, y: 2.25, th: -1.5708 }],
    ["", null],
    ["1", null],
    ["1,,2", null],
    ["1,2,3,4", null],
    ["a,b", null],
    ["1,Infinity", null],
  ])("are read: %s", (text, place) => expect(readPlace(text)).toEqual(place));

  it.each([
    [HOME, false],
    [{ x: 0.1, y: -0.1, th: HOME.th + 0.2 }, false],
    [{ x: 0, y: 0, th: HOME.th + 2 * Math.PI }, false],
    [{ x: 0.5, y: 0, th: HOME.th }, true],
    [{ x: 0, y: 0, th: Math.PI / 2 }, true],
    [{ x: 0, y: 0, th: Math.PI }, true],
  ])("are those from where one can be called back: %o", (place, away) => expect(isAway(place)).toBe(away));

  it("are measured from the dock, where the floor has one", () => {
    const place = { x: -4, y: -2.5, th: 0 };
    const things = [
      { ref: "robot/p1", kind: "person", name: "dock", place: { x: 0, y: 0, th: 0 } },
      { ref: "robot/dock", kind: "object", name: "dock", place },
    ] as const;
    const dock = findDock(things);
    expect(dock?.ref).toBe("robot/dock");
    expect(findDock(things.slice(0, 1))).toBeNull();
    expect(isAway({ ...place, th: 3 }, dock)).toBe(false);
    expect(isAway({ x: 0, y: 0, th: -Math.PI / 2 }, dock)).toBe(true);
  });

  it("are left out of corners where they cannot be read", () => {
    expect(readCorners(["0,0", "x", "1.5,2"])).toEqual([
      [0, 0],
      [1.5, 2],
    ]);
  });

  it("are written for RoIS and for people", () => {
    expect(positionText([1.005, -0.5])).toBe("1.00,-0.50");
    expect(pointWords([-0.04, 2.26])).toBe("0.0, 2.3");
  });
});

describe("the drawing", () => {
  it("shows the whole floor and a margin, the far end above", () => {
    expect(ROOM).toEqual({ left: -3.2, top: -4.2, width: 6.4, height: 5.4 });
    expect(
      drawn([
        [1, 2],
        [-1, -2],
      ]),
    ).toBe("1,-2 -1,2");
  });

  it("shows what there is, and some way around it, where there is no floor", () => {
    expect(extentOf([], [[1, 1]])).toEqual({ left: -1, top: -3, width: 4, height: 4 });
  });

  it("has a line for each metre", () => {
    expect(gridLines({ left: -0.5, top: 0.5, width: 1, height: 1 })).toBe("M0 0.5v1M-0.5 1h1");
  });

  it("turns against the clock, as angles do", () => {
    expect(turned(Math.PI / 2)).toBe(-90);
  });
});

describe("the cursor", () => {
  it.each([
    ["ArrowUp", false, [0, 0.25]],
    ["ArrowDown", false, [0, -0.25]],
    ["ArrowLeft", true, [-1, 0]],
    ["ArrowRight", false, [0.25, 0]],
    ["Enter", false, null],
  ])("%s", (key, far, to) => {
    const point = moved([0, 0], key, far, ROOM);
    expect(point?.map((value) => value + 0) ?? null).toEqual(to);
  });

  it("stays on the map", () => {
    expect(moved([3, 0], "ArrowRight", true, ROOM)?.[0]).toBeCloseTo(3.2);
    expect(moved([0, -1], "ArrowDown", true, ROOM)?.[1]).toBeCloseTo(-1.2);
  });
});

describe("things", () => {
  const described = {
    thing_ref: ["urn:x/scene/v", "urn:x/scene/t", "urn:x/scene/r", "urn:x/scene/broken"],
    kind: ["person", "object", "sound", "ghost"],
    name: ["visitor", "", "radio", "broken"],
    position_data: ["1,1,0", "2,1,0", "2.1,1,0"],
  };

  it("are read as far as they can be, and always have a name", () => {
    const things = readThings(described);
    expect(things.map(({ kind, name }) => [kind, name])).toEqual([
      ["person", "visitor"],
      ["object", "t"],
      ["sound", "radio"],
    ]);
  });

  it("are found near a point, the nearest first", () => {
    const things = readThings(described);
    expect(nearest(things, [2.08, 1.02], 0.4)?.name).toBe("radio");
    expect(nearest(things, [1, 2], 0.4)).toBeNull();
  });
});

describe("targets", () => {
  const targets = ["0,1", "0,2", "0,3"].map((text) => ({ text }));
  it("are passed one by one, and those before with them", () => {
    expect(ahead(targets, "0,1")).toEqual(targets.slice(1));
    expect(ahead(targets, "0,2")).toEqual(targets.slice(2));
    expect(ahead(targets, "elsewhere")).toEqual(targets);
  });
});
