import { describe, expect, it } from "vitest";
import { PathWatch } from "../../sdk/media/path_watch.ts";
import type { Flow, Verdict } from "../../sdk/media/path_watch.ts";

const flow = (count: number, expected = true, streamId = "s"): Flow[] => [{ streamId, expected, count }];

/** Returns the verdicts of one look a second; `counts` are the frames seen so far. */
function verdicts(counts: number[], state: RTCPeerConnectionState = "connected"): Verdict[] {
  const watch = new PathWatch();
  return counts.map((count, second) => watch.observe(second * 1000, state, flow(count)));
}

describe("PathWatch", () => {
  it("is content while frames come", () => {
    expect(new Set(verdicts([0, 30, 60, 90, 120]))).toEqual(new Set(["fine"]));
  });

  it("asks for a restart after 2 s without a frame", () => {
    expect(verdicts([30, 30, 30, 30])).toEqual(["fine", "waiting", "restart", "waiting"]);
  });

  it("asks for none while an engine sends what a thin path carries: a picture every 1.6 s", () => {
    const seen = verdicts(Array.from({ length: 60 }, (_, second) => 30 + Math.floor(second / 1.6)));
    expect(new Set(seen)).toEqual(new Set(["fine", "waiting"]));
  });

  it("gives the first frame 10 s", () => {
    const seen = verdicts(Array.from({ length: 11 }, () => 0));
    expect(seen.indexOf("restart")).toBe(10);
  });

  it("asks again, but less and less often", () => {
    const watch = new PathWatch();
    const asked: number[] = [];
    for (let second = 0; second <= 80; second++) {
      if (watch.observe(second * 1000, "failed", []) === "restart") asked.push(second);
    }
    expect(asked).toEqual([0, 5, 13, 25, 42, 68]);
    watch.observe(81_000, "connected", []);
    watch.observe(100_000, "failed", []);
    expect(watch.observe(105_000, "failed", [])).toBe("restart");
  });

  it.each([
    ["failed", 0],
    ["closed", 0],
    ["disconnected", 1],
  ] as const)("takes %s for broken after %i s", (state, after) => {
    expect(verdicts([1, 2, 3, 4, 5], state).indexOf("restart")).toBe(after);
  });

  it("forgives a short disconnection", () => {
    const watch = new PathWatch();
    expect(watch.observe(0, "disconnected", [])).toBe("waiting");
    expect(watch.observe(900, "connected", [])).toBe("fine");
    expect(watch.observe(1500, "disconnected", [])).toBe("waiting");
    expect(watch.observe(2400, "disconnected", [])).toBe("waiting");
  });

  it("expects nothing of a suspended stream, and starts anew when it resumes", () => {
    const watch = new PathWatch();
    watch.observe(0, "connected", flow(30));
    expect(watch.observe(60_000, "connected", flow(30, false))).toBe("fine");
    expect(watch.observe(61_500, "connected", flow(30))).toBe("waiting");
    expect(watch.observe(62_000, "connected", flow(31))).toBe("fine");
  });

  it("judges a stream that was connected again by its new time", () => {
    const watch = new PathWatch();
    watch.observe(0, "connected", flow(30, true, "a/1"));
    watch.observe(1000, "connected", []);
    expect(watch.observe(90_000, "connected", flow(30, true, "a/1"))).toBe("fine");
    expect(watch.observe(91_000, "connected", flow(30, true, "a/2"))).toBe("fine");
  });

  it("judges by the worst of several streams", () => {
    const watch = new PathWatch();
    const both = (audio: number): Flow[] => [...flow(5, true, "video"), ...flow(audio, true, "audio")];
    watch.observe(0, "connected", both(1));
    expect(watch.observe(4000, "connected", both(2))).toBe("restart");
  });
});
