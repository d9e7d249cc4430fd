import { describe, expect, it } from "vitest";
import { STALLED_AFTER, findTrouble } from "../../../app/model/trouble.ts";
import type { Situation } from "../../../app/model/trouble.ts";

type Change = Partial<Omit<Situation, "video">> & { video?: Partial<Situation["video"]> };

const situation = ({ video, ...change }: Change): Situation => ({
  canStream: true,
  connection: { name: "connected" },
  unwelcome: null,
  streaming: true,
  body: { name: "avatar", present: true },
  codecs: ["video/H264", "video/VP8"],
  ...change,
  video: { wanted: true, problem: null, status: "STREAMING_RUNNING", frameAge: 20, ...video },
});

describe("findTrouble", () => {
  it.each<[string, Change]>([
    ["all runs", {}],
    [
      "the page has just begun",
      { connection: { name: "connecting", attempt: 0 }, body: null, streaming: false },
    ],
    ["the profile has not been read", { body: null }],
    ["no frame was shown yet", { video: { frameAge: null } }],
    ["the stream is suspended", { video: { status: "STREAMING_SUSPENDED", frameAge: 1e6 } }],
    ["the stream is disconnected", { video: { wanted: false, problem: { kind: "no-media", detail: "" } } }],
    ["only VP8 can be decoded", { codecs: ["video/VP8"] }],
  ])("is content when %s", (_, change) => {
    expect(findTrouble(situation(change))).toBeNull();
  });

  it.each<[string, Change]>([
    ["no-webrtc", { canStream: false }],
    ["no-gateway", { connection: { name: "waiting", retryAt: 5, attempt: 1, reason: "" } }],
    ["no-gateway", { connection: { name: "connecting", attempt: 3 } }],
    ["no-token", { connection: { name: "waiting", retryAt: 5, attempt: 1, reason: "" }, unwelcome: "none" }],
    ["no-streaming", { streaming: false }],
    ["no-adapter", { body: "none" }],
    ["adapter-gone", { body: { name: "avatar", present: false } }],
    ["no-codec", { codecs: ["video/AV1"] }],
    ["no-codec", { video: { problem: { kind: "unsupported", detail: "UNSUPPORTED" } } }],
    ["no-media", { video: { problem: { kind: "no-media", detail: "ICE failed" } } }],
    ["no-streaming", { video: { problem: { kind: "no-streaming", detail: "" } } }],
    ["refused", { video: { problem: { kind: "refused", detail: "ERROR" } } }],
    ["stalled", { video: { frameAge: STALLED_AFTER + 1 } }],
  ])("says %s, and what to do", (kind, change) => {
    const trouble = findTrouble(situation(change));
    expect(trouble?.kind).toBe(kind);
    expect(trouble?.title).not.toBe("");
    expect(trouble?.text.length).toBeGreaterThan(40);
    expect(trouble?.text).not.toMatch(/ICE|[A-Z]{2,}_[A-Z]/);
  });

  it("names the cause nearest to the user first", () => {
    const all: Change = {
      connection: { name: "waiting", retryAt: 7, attempt: 1, reason: "" },
      body: { name: "avatar", present: false },
      codecs: [],
      video: { problem: { kind: "no-media", detail: "" } },
    };
    expect(findTrouble(situation(all))).toMatchObject({ kind: "no-gateway", retryAt: 7 });
    expect(findTrouble(situation({ ...all, connection: { name: "connected" } }))?.kind).toBe("adapter-gone");
  });

  it.each(["unsupported", "refused"] as const)(
    "passes on what the engine says of a stream that is %s",
    (kind) => {
      const trouble = (detail: string) =>
        findTrouble(situation({ video: { problem: { kind, detail } } }))?.text;
      expect(trouble("64 applications are served already.")).toContain(
        "“64 applications are served already”.",
      );
      expect(trouble("ERROR")).not.toContain("“");
    },
  );
});
