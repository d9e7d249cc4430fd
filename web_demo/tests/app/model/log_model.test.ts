import { describe, expect, it } from "vitest";
import { LogModel, MAX_ENTRIES, matches, pretty } from "../../../app/model/log_model.ts";
import type { Json, Traffic } from "../../../sdk/index.ts";

const traffic = (over: Partial<Traffic>): Traffic => ({
  direction: "sent",
  at: 0,
  kind: "request",
  method: "m",
  message: {},
  ...over,
});

const summary = (over: Partial<Traffic>): string => new LogModel().add(traffic(over)).summary;

describe("LogModel", () => {
  it("forgets the oldest beyond its limit", () => {
    const log = new LogModel();
    for (let index = 0; index < MAX_ENTRIES + 5; index++) log.add(traffic({ method: `m${index}` }));
    expect(log.entries).toHaveLength(MAX_ENTRIES);
    expect(log.entries[0]?.traffic.method).toBe("m5");
    log.clear();
    expect(log.entries).toEqual([]);
    expect(log.add(traffic({})).number).toBe(MAX_ENTRIES + 5);
  });

  it.each<[string, Traffic["kind"], Json]>([
    ["openrois.auth.refresh", "request", { params: { token: "canary.a.b" } }],
    ["openrois.lease.token", "response", { result: { return_code: "OK", token: "canary", grace_ms: 9 } }],
    ["openrois.lease.resume", "request", { params: { token: "canary", command_ids: [] } }],
    ["openrois.lease.resume", "response", { result: { return_code: "OK", token: "canary" } }],
    [
      "signaling.ice_servers",
      "response",
      { result: { ice_servers: [{ urls: ["turn:t"], credential: "canary" }] } },
    ],
  ])("never has the secrets of %s, %s", (method, kind, message) => {
    const log = new LogModel();
    log.add(traffic({ method, kind, message }));
    expect(JSON.stringify(log.entries)).not.toContain("canary");
    expect(JSON.stringify(log.entries)).toContain("…");
  });

  it("puts successive events of one subscription into one line", () => {
    const log = new LogModel();
    const event = (subscribe_id: string): number =>
      log.add(traffic({ method: "rois.event.notify_event", message: { params: { subscribe_id } } })).repeats;
    expect([event("a"), event("a"), event("b"), event("b")]).toEqual([1, 2, 1, 2]);
    expect(log.entries.map(({ number }) => number)).toEqual([0, 1]);
    log.add(traffic({}));
    expect(event("b")).toBe(1);
    expect(log.entries).toHaveLength(4);
  });

  it("puts a repeated query, and its response, into one line each", () => {
    const log = new LogModel();
    const add = (method: string, kind: Traffic["kind"], message: Json): number =>
      log.add(traffic({ method, kind, message })).repeats;
    const ask = (id: number, query_type: string): number =>
      add("rois.query.query", "request", { id, params: { query_type, condition: "c" } });
    const answer = (id: number, return_code = "OK"): number =>
      add("rois.query.query", "response", { id, result: { return_code } });
    const event = (): number =>
      add("rois.event.notify_event", "notification", { params: { subscribe_id: "a" } });

    expect([event(), ask(1, "things"), answer(1)]).toEqual([1, 1, 1]);
    expect([event(), ask(2, "floor"), ask(3, "things"), answer(3), answer(2)]).toEqual([2, 1, 2, 2, 1]);
    expect(log.entries).toHaveLength(5);
    expect([ask(4, "things"), answer(4, "ERROR"), ask(5, "things")]).toEqual([3, 1, 1]);
    expect(answer(99)).toBe(1);
    for (let id = 100; id < 200; id++) ask(id, "floor");
    expect([answer(101), answer(199)]).toEqual([1, 1]);
  });

  it.each<[string, Partial<Traffic>]>([
    ["speech synthesizer", { message: { params: { component_ref: "avatar/speech_synthesizer" } } }],
    ["OK", { kind: "response", message: { result: { return_code: "OK", subscribe_id: "", results: null } } }],
    [
      "OK, 2 results, my profile, 1 part",
      {
        kind: "response",
        message: {
          result: { return_code: "OK", results: [1, 2], my_profile: { a: 1 }, parts: { a: 1 }, more: [] },
        },
      },
    ],
    [
      "session description",
      {
        message: {
          params: {
            peer_id: `avatar/0a1b2c${"0".repeat(26)}`,
            generation: 7,
            sdp: "v=0",
            command_ids: ["a"],
          },
        },
      },
    ],
    ["session description", { message: { params: { sdp: "v=0\r\n" } } }],
    ["running", { message: { params: { status: "STREAMING_RUNNING", timestamp: "2026-08-01" } } }],
    [
      "refused, speech is bound by another application",
      {
        kind: "response",
        message: {
          result: { return_code: "OUT_OF_RESOURCES", reason: "a/speech is bound by another application" },
        },
      },
    ],
    [
      "teleoperation, in use, another application, position 2, its holder has handed it over",
      {
        message: {
          params: {
            lease: {
              component_ref: "avatar/teleoperation",
              state: "HELD",
              holder: "local",
              epoch: 17,
              position: 2,
            },
            reason: "its holder has handed it over",
          },
        },
      },
    ],
    [
      "Another application has control now, stopped",
      {
        message: {
          params: {
            command_id: "command-9e6ad0",
            reason: "avatar/teleoperation is now held by local: its holder has handed it over",
            status: "ABORT",
          },
        },
      },
    ],
    [
      "component status, reaction",
      {
        message: {
          params: { query_type: "component_status", condition: "component_ref = 'avatar/reaction'" },
        },
      },
    ],
    ["86 ms", { message: { params: { stream_id: "avatar/1", milliseconds: 86 } } }],
    ["lamp_1, answer 500 ms", { message: { params: { engine_id: "lamp_1", answer_ms: 500 } } }],
    ["is final", { message: { params: { is_final: true, is_first: false } } }],
    [`${"x".repeat(119)}…`, { message: { params: { text: "x".repeat(190) } } }],
    [
      "Method not found",
      { kind: "error", message: { error: { code: -32601, message: "Method not found" } } },
    ],
    ["the message is not JSON", { kind: "violation", message: "the message is not JSON" }],
    ["", { kind: "response", message: { result: 5 } }],
    [
      "set parameter → (start ∥ look)",
      {
        message: {
          params: {
            command_unit_list: [
              { command_type: "set_parameter" },
              { command_list: [{ command_type: "start" }, { command_type: "look" }] },
            ],
          },
        },
      },
    ],
  ])("puts a message into one line: %s", (expected, over) => {
    expect(summary(over)).toBe(expected);
  });

  it.each<[boolean, Partial<Traffic>]>([
    [false, { kind: "response", message: { result: { return_code: "OK" } } }],
    [false, { kind: "notification", message: { params: {} } }],
    [true, { kind: "response", message: { result: { return_code: "ERROR" } } }],
    [true, { kind: "error", message: { error: {} } }],
    [true, { kind: "violation", message: "?" }],
  ])("knows a failure: %s", (failed, over) => {
    expect(new LogModel().add(traffic(over)).failed).toBe(failed);
  });
});

describe("matches", () => {
  const entry = new LogModel().add(
    traffic({ direction: "received", method: "rois.stream.notify_stream_status", message: { a: "RUNNING" } }),
  );

  it.each<[string, boolean]>([
    ["", true],
    ["stream", true],
    ["STREAM running", true],
    ["received  notify", true],
    ["stream suspended", false],
  ])("the filter %o: %s", (filter, expected) => {
    expect(matches(entry, filter)).toBe(expected);
  });
});

describe("pretty", () => {
  it("shortens session descriptions, wherever they are", () => {
    const sdp = `v=0\r\n${"a=x\r\n".repeat(50)}m=video 9 UDP\r\nm=audio 9 UDP\r\n`;
    const text = pretty({ params: { sdp, other: sdp } } as Json);
    expect(text).toContain(`… (${sdp.length} characters; video, audio)`);
    expect(JSON.parse(text)).toMatchObject({ params: { other: sdp } });
  });

  it("leaves short ones alone", () => {
    expect(JSON.parse(pretty({ sdp: "v=0" }))).toEqual({ sdp: "v=0" });
  });
});
