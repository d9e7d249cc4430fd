import { afterEach, beforeEach, expect, it, vi } from "vitest";
import { Activity } from "../../../app/dom/activity.ts";

let root: EventTarget;
let activity: Activity;
const page = { visibilityState: "visible" };
const pads: { timestamp: number }[] = [];

beforeEach(() => {
  vi.useFakeTimers();
  vi.stubGlobal("document", page);
  vi.stubGlobal("navigator", { getGamepads: () => pads });
  page.visibilityState = "visible";
  pads.length = 0;
  root = new EventTarget();
  activity = new Activity(root);
  activity.within(0);
  vi.advanceTimersByTime(5000);
});

afterEach(() => {
  vi.useRealTimers();
  vi.unstubAllGlobals();
});

it("counts keys and pointers", () => {
  expect(activity.within(4000)).toBe(false);
  root.dispatchEvent(new Event("pointermove"));
  expect(activity.within(4000)).toBe(true);
  vi.advanceTimersByTime(4001);
  expect(activity.within(4000)).toBe(false);
});

it("counts what is done with a gamepad", () => {
  pads.push({ timestamp: 1 });
  expect(activity.within(4000)).toBe(true);
  vi.advanceTimersByTime(4001);
  expect(activity.within(4000)).toBe(false);
});

it("counts nothing while the page cannot be seen", () => {
  root.dispatchEvent(new Event("keydown"));
  page.visibilityState = "hidden";
  expect(activity.within(4000)).toBe(false);
});
