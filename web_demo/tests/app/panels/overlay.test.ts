import { describe, expect, it } from "vitest";
import { Freezes, STILL_AFTER } from "../../../app/model/readings.ts";
import { History, roundTop } from "../../../app/dom/sparkline.ts";

describe("roundTop", () => {
  it.each([
    [0, 30, 50],
    [29, 50, 50],
    [50, 50, 50],
    [51, 50, 100],
    [0.3, 0.1, 0.5],
    [1_340_000, 100e3, 2e6],
    [600, 1, 1000],
  ])("of %s, at least %s, is %s", (value, least, top) => {
    expect(roundTop(value, least)).toBe(top);
  });
});

describe("History", () => {
  it("is drawn on a scale that is given", () => {
    const history = new History(3);
    for (const value of [0, 50, 100]) history.push(value);
    expect(history.greatest).toBe(100);
    expect(history.paths(20, 10, 200).line).toBe("M0.0 10.0L10.0 7.5L20.0 5.0");
  });
});

describe("Freezes", () => {
  it("counts what is longer than any frame should take, second by second", () => {
    const freezes = new Freezes();
    for (const now of [0, 33, 66, 100]) freezes.frame(now);
    expect(freezes.collectFrozen(100 + STILL_AFTER)).toBe(0);
    expect(freezes.collectFrozen(1000)).toBe(900 - STILL_AFTER);
    expect(freezes.collectFrozen(2000)).toBe(1000);
    freezes.frame(2100);
    freezes.frame(2133);
    expect(freezes.collectFrozen(2150)).toBe(100);
  });

  it("starts with the first frame, and again after a pause", () => {
    const freezes = new Freezes();
    expect(freezes.collectFrozen(5000)).toBe(0);
    freezes.frame(5000);
    freezes.pause();
    expect(freezes.collectFrozen(9000)).toBe(0);
    freezes.frame(9000);
    freezes.frame(9000 + STILL_AFTER + 50);
    expect(freezes.collectFrozen(9999)).toBe(50 + (999 - STILL_AFTER - 50 - STILL_AFTER));
  });
});
