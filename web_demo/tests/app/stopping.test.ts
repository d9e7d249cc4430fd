import { afterEach, beforeEach, expect, it, vi } from "vitest";
import { stopUntilEnded } from "../../app/stopping.ts";

beforeEach(() => void vi.useFakeTimers());
afterEach(() => void vi.useRealTimers());

it("stops what begins only afterwards, and no more than that", async () => {
  let runs = true;
  const stop = vi.fn(() =>
    stop.mock.calls.length > 1 ? ((runs = false), Promise.resolve()) : Promise.reject(new Error()),
  );
  const component = { inUse: false, stop };
  await stopUntilEnded(component, () => runs);
  expect(stop).not.toHaveBeenCalled();
  component.inUse = true;
  await vi.advanceTimersByTimeAsync(10_000);
  expect(stop).toHaveBeenCalledTimes(2);
});

it("gives up in the end", async () => {
  const stop = vi.fn(() => Promise.resolve());
  await stopUntilEnded({ inUse: true, stop }, () => true);
  await vi.advanceTimersByTimeAsync(60_000);
  expect(stop).toHaveBeenCalledTimes(20);
});
