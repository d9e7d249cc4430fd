import { afterEach, beforeEach, expect, it, vi } from "vitest";
import { AFTER, Talking } from "../../../app/model/talking.ts";

beforeEach(() => void vi.useFakeTimers());
afterEach(() => void vi.useRealTimers());

/** Returns a microphone that is switched at once, and the talking with it. */
function made(isOn = false) {
  const control = {
    isOn,
    toggle: async () => void (control.isOn = !control.isOn),
    off: async () => void (control.isOn = false),
  };
  const stream = { muted: false };
  const changes: boolean[] = [];
  const talking: Talking = new Talking(
    () => ({ control, stream }),
    () => changes.push(talking.held),
  );
  return { control, stream, talking, changes };
}

it("sends sound while it is held, then silence, then nothing", async () => {
  const { control, stream, talking, changes } = made();
  talking.press();
  talking.press();
  expect([control.isOn, stream.muted]).toEqual([true, false]);
  talking.release();
  talking.release();
  expect([control.isOn, stream.muted]).toEqual([true, true]);
  await vi.advanceTimersByTimeAsync(AFTER);
  expect([control.isOn, stream.muted]).toEqual([false, false]);
  expect(changes).toEqual([true, false, false]);
});

it("goes on where it is pressed again in time", async () => {
  const { control, stream, talking } = made();
  talking.press();
  talking.release();
  await vi.advanceTimersByTimeAsync(AFTER - 1);
  talking.press();
  expect([control.isOn, stream.muted]).toEqual([true, false]);
  await vi.advanceTimersByTimeAsync(2 * AFTER);
  expect([control.isOn, stream.muted]).toEqual([true, false]);
});

it("leaves a microphone alone that is on by its own switch", async () => {
  const { control, stream, talking } = made(true);
  talking.press();
  talking.release();
  expect([control.isOn, stream.muted]).toEqual([true, false]);
  await vi.advanceTimersByTimeAsync(2 * AFTER);
  expect([control.isOn, stream.muted]).toEqual([true, false]);
});

it("ends at once where the connection is lost while it is held", () => {
  const { control, talking, changes } = made();
  talking.press();
  talking.end();
  expect([control.isOn, talking.held]).toEqual([false, false]);
  expect(changes).toEqual([true, false]);
});

it("does nothing where the body takes no sound", () => {
  const talking = new Talking(
    () => null,
    () => undefined,
  );
  talking.press();
  expect(talking.held).toBe(false);
});
