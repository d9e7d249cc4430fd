import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import { Hush } from "../../sdk/media/hush.ts";

beforeEach(() => void vi.useFakeTimers());
afterEach(() => void vi.useRealTimers());

const pass = (ms: number): Promise<unknown> => vi.advanceTimersByTimeAsync(ms);

describe("Hush", () => {
  it("silences at once, and until the buffer has run out after the cut", async () => {
    const track = { enabled: true };
    let cut = (): void => undefined;
    void new Hush().begin(track, () => 150, new Promise<void>((resolve) => (cut = resolve)));
    expect(track.enabled).toBe(false);
    await pass(500);
    expect(track.enabled).toBe(false);
    cut();
    await pass(200);
    expect(track.enabled).toBe(false);
    await pass(20);
    expect(track.enabled).toBe(true);
  });

  it("is bounded for any delay and cut", async () => {
    const track = { enabled: true };
    void new Hush().begin(track, () => 1e6, new Promise(() => undefined));
    await pass(3001);
    expect(track.enabled).toBe(true);
  });

  it("restores the sound after a failed interruption", async () => {
    const track = { enabled: true };
    await Promise.all([new Hush().begin(track, () => null, Promise.reject(new Error("gone"))), pass(300)]);
    expect(track.enabled).toBe(true);
  });

  it("ends with the last one of several, and never leaves a track behind", async () => {
    const [one, other] = [{ enabled: true }, { enabled: true }];
    const hush = new Hush();
    void hush.begin(one, () => 100, Promise.resolve());
    await pass(100);
    void hush.begin(one, () => 100, Promise.resolve());
    await pass(100);
    expect(one.enabled).toBe(false);
    void hush.begin(other, () => 100, Promise.resolve());
    expect([one.enabled, other.enabled]).toEqual([true, false]);
    await pass(160);
    expect(other.enabled).toBe(true);
  });
});
