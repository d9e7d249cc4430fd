import { describe, expect, it } from "vitest";
import { Faces, gestureWords, inMirror, readBox } from "../../../app/senses/boxes.ts";

const rounded = (box: object): object =>
  Object.fromEntries(
    Object.entries(box).map(([side, share]) => [side, Number((share as number).toFixed(4))]),
  );

describe("boxes", () => {
  it.each([
    ["0.1,0.2,0.3,0.4", { left: 0.1, top: 0.2, width: 0.3, height: 0.4 }],
    ["-0.1,0,0.3,0.4", { left: -0.1, top: 0, width: 0.3, height: 0.4 }],
    ["0.1,0.2,0.3", null],
    ["0.1,0.2,0.3,", null],
    ["0.1,0.2,0,0.4", null],
    ["a,b,c,d", null],
  ])("are read: %s", (text, box) => expect(readBox(text)).toEqual(box));

  it("are on the other side in a mirror", () => {
    const box = { left: 0.1, top: 0.2, width: 0.3, height: 0.4 };
    expect(rounded(inMirror(box, 16 / 9, 16 / 9))).toEqual({ left: 0.6, top: 0.2, width: 0.3, height: 0.4 });
  });

  it("keep to the picture where its edges are cut off", () => {
    const middle = { left: 0.4, top: 0.4, width: 0.2, height: 0.2 };
    expect(rounded(inMirror(middle, 1, 2))).toEqual({ left: 0.4, top: 0.3, width: 0.2, height: 0.4 });
    expect(rounded(inMirror(middle, 2, 1))).toEqual({ left: 0.3, top: 0.4, width: 0.4, height: 0.2 });
  });
});

describe("faces", () => {
  const seen = (gesture: string, box = "0.1,0.1,0.2,0.2") => ({
    person_ref: ["p/1"],
    box: [box],
    name: ["Ann"],
    gesture_ref: [gesture],
  });

  it("have a reported gesture for two seconds", () => {
    const faces = new Faces();
    const gesture = (now: number, gesture_ref = ""): string | undefined =>
      faces.see(seen(gesture_ref), now)[0]?.gesture;
    expect([gesture(0), gesture(100, "urn:x-rois:def:gesture:OMG::1"), gesture(1000), gesture(2100)]).toEqual(
      ["", "nods", "nods", ""],
    );
  });

  it("are left out where they cannot be read", () => {
    expect(new Faces().see(seen("", "nowhere"), 0)).toEqual([]);
  });

  it("make other gestures, too", () => {
    expect(["", "urn:x-rois:def:gesture:OMG::3", "urn:x:Own::thumb_up"].map(gestureWords)).toEqual([
      "",
      "shakes the head",
      "thumb up",
    ]);
  });
});
