import { describe, expect, it } from "vitest";
import { SILENCE, filled, levelOf, spoken } from "../../../app/model/decibels.ts";
import { deviceTrouble, deviceWords, sendingWords } from "../../../app/model/device_words.ts";

describe("deviceWords", () => {
  it.each([
    [false, false, null, false, "off"],
    [false, true, null, true, "asking"],
    [false, false, null, true, "trouble"],
    [true, false, null, false, "waiting"],
    [true, false, "STREAMING_NOT_RUNNING", false, "waiting"],
    [true, false, "STREAMING_RUNNING", false, "on"],
    [true, false, "STREAMING_SUSPENDED", false, "held"],
  ] as const)("in use %s, asking %s, %s, failed %s: %s", (on, asking, status, failed, state) => {
    expect(deviceWords(on, asking, status, failed).state).toBe(state);
  });
});

describe("what leaves this machine", () => {
  it("is said plainly, and what becomes of it", () => {
    const sent = (used: string): string => deviceWords(true, false, "STREAMING_RUNNING", false, used).text;
    expect([sent(""), sent("looked at")]).toEqual(["Sent", "Sent, looked at"]);
    const words = [sendingWords(true, true), sendingWords(true, false), sendingWords(false, true)];
    expect(words).toEqual(["Microphone and camera are on", "Microphone is on", "Camera is on"]);
    expect(sendingWords(false, false)).toBe("");
  });
});

describe("deviceTrouble", () => {
  it("is about the device first, then about the stream", () => {
    const device = { kind: "refused", detail: "Allow it." } as const;
    const stream = { kind: "refused", detail: "another application sends already" } as const;
    expect(deviceTrouble(device, stream)).toBe("Allow it.");
    expect(deviceTrouble(null, stream)).toBe("The body does not take it: another application sends already.");
    expect(deviceTrouble(null, { kind: "unsupported", detail: "UNSUPPORTED" })).toBe(
      "The body does not take it.",
    );
    expect(deviceTrouble(null, { kind: "no-media", detail: "" })).toContain("gets through");
    expect(deviceTrouble(null, { kind: "no-streaming", detail: "" })).toContain("gateway");
    expect(deviceTrouble(null, null)).toBeNull();
  });
});

describe("levels", () => {
  it("are those of a sine that just fits, and of silence", () => {
    const sine = Float32Array.from({ length: 480 }, (_, index) => Math.sin((2 * Math.PI * index) / 48));
    const { rms, peak } = levelOf(sine);
    expect(rms).toBeCloseTo(-3.01, 1);
    expect(peak).toBeCloseTo(0, 2);
    expect(levelOf(new Float32Array(8))).toEqual(SILENCE);
  });

  it("fill a bar in equal steps of dB", () => {
    expect([0, -30, -60, -100, 3].map(filled)).toEqual([1, 0.5, 0, 0, 1]);
  });

  it("are read aloud in words", () => {
    const words = [0, -20, -40, -70].map((rms) => spoken({ rms, peak: rms }));
    expect(words).toEqual(["too loud", "loud", "quiet", "silent"]);
  });
});
