import { describe, expect, it } from "vitest";
import { RecentMedian, figuresBetween, readSample } from "../../sdk/media/statistics.ts";
import type { Sample } from "../../sdk/media/statistics.ts";

const sample = (over: Partial<Sample>): Sample => ({
  at: 0,
  bytes: 0,
  packets: 0,
  packetsLost: 0,
  units: 0,
  dropped: 0,
  bufferDelay: 0,
  bufferCount: 0,
  deviceDelay: 0,
  deviceCount: 0,
  frozen: 0,
  codec: "",
  width: 640,
  height: 360,
  roundTrip: null,
  ...over,
});

describe("figuresBetween", () => {
  it("divides what happened by the time it took", () => {
    const before = sample({
      at: 1000,
      bytes: 1000,
      packets: 100,
      units: 10,
      bufferDelay: 1,
      bufferCount: 10,
    });
    const after = sample({
      at: 3000,
      bytes: 251_000,
      units: 70,
      dropped: 3,
      packets: 298,
      packetsLost: 2,
      bufferDelay: 2.2,
      bufferCount: 70,
      deviceDelay: 3,
      deviceCount: 100,
      frozen: 0.25,
      codec: "video/VP8",
      roundTrip: 4,
    });
    expect(figuresBetween(before, after)).toEqual({
      rate: 30,
      bitrate: 1_000_000,
      width: 640,
      height: 360,
      roundTrip: 4,
      dropped: 3,
      packetsLost: 2,
      loss: 0.01,
      frozen: 250,
      codec: "video/VP8",
      bufferDelay: expect.closeTo(20, 6),
      deviceDelay: expect.closeTo(30, 6),
    });
  });

  it("takes a packet that came after all for none that was lost", () => {
    expect(figuresBetween(sample({ packetsLost: 5 }), sample({ at: 1000, packetsLost: 3 }))?.loss).toBe(0);
  });

  it("has no buffer delay when nothing left the buffer", () => {
    expect(figuresBetween(sample({}), sample({ at: 1000 }))?.bufferDelay).toBeNull();
  });

  it.each([
    ["no time between them", {}, {}],
    ["counters that went back", { bytes: 5 }, { at: 1000 }],
    ["frames that went back", { units: 5 }, { at: 1000, bytes: 9 }],
  ])("is null with %s", (_, before, after) => {
    expect(figuresBetween(sample(before), sample(after))).toBeNull();
  });
});

describe("readSample", () => {
  const pair = { type: "candidate-pair", nominated: true, state: "succeeded", currentRoundTripTime: 0.0123 };
  const video = {
    type: "inbound-rtp",
    kind: "video",
    bytesReceived: 10,
    packetsReceived: 99,
    packetsLost: 1,
    framesDecoded: 3,
    framesDropped: 2,
    jitterBufferDelay: 0.5,
    jitterBufferEmittedCount: 3,
    frameWidth: 1280,
    frameHeight: 720,
    totalFreezesDuration: 1.5,
    codecId: "c",
  };

  it("reads a video", () => {
    expect(readSample([{ type: "codec", id: "c", mimeType: "video/H264" }, pair, video], 7)).toEqual({
      at: 7,
      bytes: 10,
      packets: 99,
      packetsLost: 1,
      units: 3,
      dropped: 2,
      bufferDelay: 0.5,
      bufferCount: 3,
      deviceDelay: 0,
      deviceCount: 0,
      frozen: 1.5,
      codec: "video/H264",
      width: 1280,
      height: 720,
      roundTrip: 12.3,
    });
  });

  it("counts packets of audio, and takes what is missing for 0", () => {
    const read = readSample([{ type: "inbound-rtp", kind: "audio", packetsReceived: 50 }], 0);
    expect(read).toMatchObject({ units: 50, bytes: 0, width: 0, roundTrip: null });
  });

  it("takes the round trip of the pair in use only", () => {
    const others = [
      { ...pair, nominated: false },
      { ...pair, state: "failed" },
      { ...pair, currentRoundTripTime: undefined },
    ];
    expect(readSample([...others, video], 0)?.roundTrip).toBeNull();
  });

  it("reads what is sent, and what the other end says of it", () => {
    const sent = { type: "outbound-rtp", kind: "video", bytesSent: 5, packetsSent: 4, framesSent: 2 };
    const read = readSample([{ type: "remote-inbound-rtp", packetsLost: 1 }, pair, sent], 0);
    expect(read).toMatchObject({ bytes: 5, packets: 4, packetsLost: 1, units: 2, roundTrip: 12.3 });
    const sound = { type: "outbound-rtp", kind: "audio", packetsSent: 4 };
    expect(readSample([sound], 0)).toMatchObject({ units: 4, packetsLost: 0 });
  });

  it("is null before anything is received", () => {
    expect(readSample([pair], 0)).toBeNull();
  });
});

describe("RecentMedian", () => {
  it("is the middle of what came lately", () => {
    const median = new RecentMedian(1000);
    expect(median.value(0)).toBeNull();
    for (const [at, value] of [
      [0, 100],
      [500, 10],
      [900, 30],
    ] as const)
      median.push(at, value);
    expect(median.value(999)).toBe(30);
    expect(median.value(1200)).toBe(20);
    expect(median.value(5000)).toBeNull();
  });

  it("keeps a bounded number", () => {
    const median = new RecentMedian(1e9, 3);
    for (const value of [1, 2, 3, 4, 5]) median.push(0, value);
    expect(median.value(0)).toBe(4);
  });
});
