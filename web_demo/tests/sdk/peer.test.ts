import { describe, expect, it } from "vitest";
import { MAX_MESSAGE_LENGTH, Peer } from "../../sdk/jsonrpc/peer.ts";
import type { Incoming } from "../../sdk/jsonrpc/peer.ts";

const text = (message: object): string => JSON.stringify({ jsonrpc: "2.0", ...message });

describe("Peer", () => {
  it("writes requests with ids that are never used twice", () => {
    const peer = new Peer();
    const first = peer.request("a", { x: 1 });
    const second = peer.request("a", {});
    expect(JSON.parse(first.text)).toEqual({ jsonrpc: "2.0", id: first.id, method: "a", params: { x: 1 } });
    expect(second.id).not.toBe(first.id);
    expect(peer.outstanding).toBe(2);
  });

  it("matches answers to requests, in any order", () => {
    const peer = new Peer();
    const a = peer.request("a", {}).id;
    const b = peer.request("b", {}).id;
    expect(peer.receive(text({ id: b, result: { ok: true } }))).toEqual({
      kind: "response",
      id: b,
      method: "b",
      result: { ok: true },
    });
    const error = { code: -32601, message: "Method not found", data: [1] };
    expect(peer.receive(text({ id: a, error }))).toEqual({ kind: "error", id: a, method: "a", error });
    expect(peer.outstanding).toBe(0);
  });

  it("reads notifications and requests, with or without params", () => {
    const peer = new Peer();
    expect(peer.receive(text({ method: "m", params: { a: null } }))).toEqual({
      kind: "notification",
      method: "m",
      params: { a: null },
    });
    expect(peer.receive(text({ method: "m" }))).toEqual({ kind: "notification", method: "m", params: {} });
    expect(peer.receive(text({ id: "x", method: "m", params: null }))).toEqual({
      kind: "request",
      id: "x",
      method: "m",
      params: {},
    });
  });

  it.each([
    ["not JSON", "{", -32700],
    ["too long", " ".repeat(MAX_MESSAGE_LENGTH + 1), -32700],
    ["a batch", "[]", -32600],
    ["a number", "1", -32600],
    ["no version", '{"id":1,"method":"m"}', -32600],
    ["a wrong version", '{"jsonrpc":"1.0","id":1,"method":"m"}', -32600],
    ["an id that is true", text({ id: true, method: "m" }), -32600],
    ["an id that is an object", text({ id: {}, method: "m" }), -32600],
    ["a method that is no string", text({ id: 1, method: 2 }), -32600],
    ["params in a list", text({ id: 1, method: "m", params: [] }), -32602],
    ["nothing at all", text({ id: 1 }), -32600],
  ])("answers %s with an error", (_, message, code) => {
    const incoming = new Peer().receive(message);
    expect(incoming.kind).toBe("violation");
    const { answer } = incoming as Extract<Incoming, { kind: "violation" }>;
    expect(JSON.parse(answer ?? "null")).toMatchObject({ jsonrpc: "2.0", error: { code } });
  });

  it.each([
    ["a notification with params in a list", text({ method: "m", params: [] })],
    ["a response to an id that is not outstanding", text({ id: 7, result: 1 })],
    ["an answer whose id only looks like ours", text({ id: "1", result: 1 })],
    ["an error without an id", text({ id: null, error: { code: -32700, message: "" } })],
  ])("does not answer %s", (_, message) => {
    const peer = new Peer();
    peer.request("m", {});
    expect(peer.receive(message)).toMatchObject({ kind: "violation", answer: null });
    expect(peer.outstanding).toBe(1);
  });

  it("takes an answer once, and none after it has given up waiting", () => {
    const peer = new Peer();
    const { id } = peer.request("m", {});
    expect(peer.receive(text({ id, result: 1 })).kind).toBe("response");
    expect(peer.receive(text({ id, result: 1 })).kind).toBe("violation");
    const late = peer.request("m", {}).id;
    peer.abandonRequest(late);
    expect(peer.receive(text({ id: late, result: 1 })).kind).toBe("violation");
  });

  it.each([
    ["no object", 1],
    ["a code in words", { code: "x", message: "" }],
    ["a code that is no integer", { code: 1.5, message: "" }],
    ["no message", { code: 1 }],
  ])("still settles the request when its error is malformed: %s", (_, error) => {
    const peer = new Peer();
    const { id } = peer.request("m", {});
    expect(peer.receive(text({ id, error }))).toMatchObject({ kind: "error", id, error: { code: -32600 } });
  });

  it("takes an answer with both result and error for an error", () => {
    const peer = new Peer();
    const { id } = peer.request("m", {});
    expect(peer.receive(text({ id, result: 1, error: null })).kind).toBe("error");
  });

  it("survives whatever comes in", () => {
    const random = mulberry32(20260801);
    const pieces = [
      '{"jsonrpc":"2.0"',
      ',"id":',
      "1",
      "null",
      '"method":',
      '"m"',
      ',"params":',
      "{",
      "}",
      "[",
      "]",
    ];
    const more = [
      ',"result":',
      ',"error":',
      '{"code":-1,"message":"x"}',
      "1e999",
      '"__proto__":',
      "\u0000",
      "true",
      ",",
    ];
    const peer = new Peer();
    const kinds = new Set<string>();
    for (let round = 0; round < 3000; round++) {
      if (round % 10 === 0) peer.request("m", {});
      let message = round % 3 === 0 ? '{"jsonrpc":"2.0"' : "";
      const length = Math.floor(random() * 8);
      for (let i = 0; i < length; i++) {
        const all = [...pieces, ...more];
        message += all[Math.floor(random() * all.length)] ?? "";
      }
      kinds.add(peer.receive(round % 2 === 0 ? `${message}}` : message).kind);
    }
    expect(kinds).toContain("violation");
    expect({}).not.toHaveProperty("jsonrpc");
  });

  it("reads back what any JSON value becomes", () => {
    const peer = new Peer();
    for (const value of [null, 0, -0.5, "", "\u2028😀", [], [[]], { a: { b: [1, "2", null] } }]) {
      const { id } = peer.request("m", { value });
      expect(peer.receive(text({ id, result: value }))).toMatchObject({ kind: "response", result: value });
    }
  });
});

/** A small seeded generator: a test that fails fails again. */
function mulberry32(seed: number): () => number {
  let state = seed;
  return () => {
    state = (state + 0x6d2b79f5) | 0;
    let t = Math.imul(state ^ (state >>> 15), 1 | state);
    t = (t + Math.imul(t ^ (t >>> 7), 61 | t)) ^ t;
    return ((t ^ (t >>> 14)) >>> 0) / 4294967296;
  };
}
