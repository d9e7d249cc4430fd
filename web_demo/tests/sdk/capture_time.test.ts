import { describe, expect, it } from "vitest";
import { captureTime } from "../../sdk/media/capture_time.ts";

const CLOCK = { mid: "0", ssrc: 7, clock_rate: 90_000, rtp_origin: 1000, wall: 1_800_000_000_000 };

describe("captureTime", () => {
  it.each([
    [1000, 0],
    [1000 + 90_000, 1000],
    [1000 + 3, 3 / 90],
    [0, -1000 / 90],
    [2 ** 32 - 1, -1001 / 90],
    [2 ** 31 + 999, (2 ** 31 - 1) / 90],
    [2 ** 31 + 1000, -(2 ** 31) / 90],
  ])("counts from the origin, both ways: %d", (rtpTimestamp, expected) => {
    expect(captureTime(CLOCK, rtpTimestamp) - CLOCK.wall).toBeCloseTo(expected, 2);
  });

  it("goes on where timestamps wrap around", () => {
    const clock = { ...CLOCK, rtp_origin: 2 ** 32 - 90 };
    expect(captureTime(clock, 90) - CLOCK.wall).toBeCloseTo(2, 3);
  });
});
