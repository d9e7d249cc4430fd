import { describe, expect, it, vi } from "vitest";
import {
  captureTime,
  estimateOffset,
  isLoopback,
  measureOffset,
  parseDateTime,
  wallNow,
} from "../../sdk/media/engine_clock.ts";

describe("estimateOffset", () => {
  it("trusts the quickest answer", () => {
    const probes = [
      { sent: 0, remote: 1100, received: 100 },
      { sent: 200, remote: 1205, received: 204 },
      { sent: 300, remote: 1330, received: 360 },
    ];
    expect(estimateOffset(probes)).toEqual({ offset: 1003, uncertainty: 2 });
  });

  it("is off by no more than half a round trip, wherever the time went", () => {
    const truth = -2500;
    for (const there of [0, 3, 10]) {
      const found = estimateOffset([{ sent: 50, remote: 50 + there + truth, received: 60 }]);
      expect(Math.abs((found?.offset ?? Number.NaN) - truth)).toBeLessThanOrEqual(found?.uncertainty ?? 0);
    }
  });

  it("has no opinion without an answer, nor of a clock that ran backwards", () => {
    expect(estimateOffset([])).toBeNull();
    expect(estimateOffset([{ sent: 10, remote: 0, received: 5 }])).toBeNull();
  });
});

describe("parseDateTime", () => {
  it.each([
    ["2026-08-01T00:00:00+00:00", 0],
    ["2026-08-01T00:00:00.123456+00:00", 123.456],
    ["2026-08-01T02:00:00.5+02:00", 500],
    ["2026-08-01T00:00:01Z", 1000],
  ])("reads %s", (text, after) => {
    expect(parseDateTime(text)).toBeCloseTo(Date.UTC(2026, 7, 1) + after, 6);
  });

  it("is not a number for anything else", () => {
    expect(parseDateTime("")).toBeNaN();
    expect(parseDateTime("yesterday.5")).toBeNaN();
  });
});

describe("isLoopback", () => {
  it.each(["localhost", "avatar.localhost", "127.0.0.1", "127.1.2.3", "[::1]"])(
    "%s is this machine",
    (name) => {
      expect(isLoopback(name)).toBe(true);
    },
  );

  it.each(["192.168.0.7", "robot", "localhost.example", "128.0.0.1", ""])("%s is another", (name) => {
    expect(isLoopback(name)).toBe(false);
  });
});

describe("measureOffset", () => {
  it("asks the component five times", async () => {
    let time = 0;
    const query = vi.fn(() => {
      time += query.mock.calls.length === 3 ? 2 : 20;
      return Promise.resolve([
        { name: "timestamp", data_type_ref: "DateTime", value: new Date(time + 5000).toISOString() },
      ]);
    });
    const found = await measureOffset({ query }, "a'b/system_info", () => time);
    expect(query).toHaveBeenCalledTimes(5);
    expect(query).toHaveBeenCalledWith("robot_position", "component_ref = 'a''b/system_info'");
    expect(found).toEqual({ offset: 5001, uncertainty: 1 });
  });

  it("is null when no time comes back", async () => {
    await expect(measureOffset({ query: () => Promise.resolve([]) }, "a/b")).resolves.toBeNull();
  });
});

it("the wall clock agrees with Date.now, also after the system's clock was set", () => {
  expect(Math.abs(wallNow() - Date.now())).toBeLessThan(5);
  const set = vi.spyOn(Date, "now").mockReturnValue(5_000_000);
  expect(wallNow()).toBe(5_000_000.5);
  set.mockRestore();
});

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
