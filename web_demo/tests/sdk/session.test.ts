import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import type { Json } from "../../sdk/jsonrpc/peer.ts";
import type { Traffic } from "../../sdk/jsonrpc/session.ts";
import { ConnectionLost, JsonRpcSession, RequestTimeout, RpcError } from "../../sdk/jsonrpc/session.ts";
import { FakeSocket } from "../support/fake_gateway.ts";

const sent: string[] = [];
let socket: FakeSocket;

beforeEach(() => {
  vi.useFakeTimers();
  sent.length = 0;
  socket = new FakeSocket("ws://test/", [], (_, text) => sent.push(text));
  socket.open();
});

afterEach(() => {
  vi.useRealTimers();
});

const answer = (body: object): void => socket.deliver(JSON.stringify({ jsonrpc: "2.0", ...body }));

describe("JsonRpcSession", () => {
  it("resolves with the result, rejects with the error", async () => {
    const session = new JsonRpcSession(socket);
    const good = session.request("a");
    const bad = session.request("b");
    answer({ id: 2, error: { code: -32602, message: "Invalid params", data: [] } });
    answer({ id: 1, result: 5 });
    await expect(good).resolves.toBe(5);
    await expect(bad).rejects.toMatchObject({ name: "RpcError", code: -32602, method: "b", data: [] });
    await expect(bad).rejects.toBeInstanceOf(RpcError);
    const cases: [Json | undefined, string][] = [
      [
        [
          { path: "name", message: "is missing" },
          { path: "x", message: "is unknown" },
        ],
        ": name: is missing; x: is unknown",
      ],
      [[null, 7], ": undefined: undefined; undefined: undefined"],
      ["text", ""],
      [undefined, ""],
    ];
    for (const [data, end] of cases) {
      const error = { code: -32602, message: "Invalid params", ...(data !== undefined && { data }) };
      expect(new RpcError(error, "b").message).toBe(`b: Invalid params (-32602)${end}`);
    }
  });

  it("shows every message to the observer, with the time an answer took", async () => {
    const seen: Traffic[] = [];
    const session = new JsonRpcSession(socket, { onTraffic: (traffic) => seen.push(traffic) });
    const pending = session.request("a", { x: 1 });
    vi.advanceTimersByTime(7);
    answer({ id: 1, result: null });
    await pending;
    answer({ method: "n", params: {} });
    socket.deliver("junk");
    answer({ id: 9, method: "please" });
    expect(seen.map(({ direction, kind, method }) => [direction, kind, method])).toEqual([
      ["sent", "request", "a"],
      ["received", "response", "a"],
      ["received", "notification", "n"],
      ["received", "violation", ""],
      ["received", "request", "please"],
    ]);
    expect(seen[0]?.message).toEqual({ jsonrpc: "2.0", id: 1, method: "a", params: { x: 1 } });
    expect(seen[1]?.elapsed).toBe(7);
  });

  it("refuses requests of the other side and malformed messages", () => {
    new JsonRpcSession(socket);
    answer({ id: "x", method: "please" });
    socket.deliver("junk");
    expect(sent.map((text) => JSON.parse(text))).toMatchObject([
      { id: "x", error: { code: -32601 } },
      { id: null, error: { code: -32700 } },
    ]);
  });

  it("passes notifications on in order", () => {
    const methods: string[] = [];
    new JsonRpcSession(socket, { onNotification: ({ method }) => methods.push(method) });
    answer({ method: "one" });
    answer({ method: "two" });
    expect(methods).toEqual(["one", "two"]);
  });

  it("gives up an unanswered request, and closes a silent socket", async () => {
    const onClose = vi.fn();
    const session = new JsonRpcSession(socket, { requestTimeout: 1000, onClose });
    const slow = expect(session.request("slow")).rejects.toBeInstanceOf(RequestTimeout);
    vi.advanceTimersByTime(900);
    answer({ method: "alive" });
    vi.advanceTimersByTime(100);
    await slow;
    expect(onClose).not.toHaveBeenCalled();
    const dead = expect(session.request("dead")).rejects.toBeInstanceOf(RequestTimeout);
    vi.advanceTimersByTime(1000);
    await dead;
    expect(onClose).toHaveBeenCalledWith(4000, "no answer");
    expect(socket.readyState).toBe(3);
  });

  it("passes a late result to onLate once", async () => {
    const late = vi.fn();
    const session = new JsonRpcSession(socket, { requestTimeout: 1000 });
    const slow = expect(session.request("slow", {}, late)).rejects.toBeInstanceOf(RequestTimeout);
    const refused = expect(session.request("refused", {}, late)).rejects.toBeInstanceOf(RequestTimeout);
    vi.advanceTimersByTime(900);
    answer({ method: "alive" });
    vi.advanceTimersByTime(100);
    await slow;
    await refused;
    answer({ id: 2, error: { code: -32603, message: "no" } });
    answer({ id: 1, result: { n: 1 } });
    answer({ id: 1, result: { n: 2 } });
    expect(late).toHaveBeenCalledExactlyOnceWith({ n: 1 });
  });

  it("fails every waiter when the socket closes, and every request after", async () => {
    const onClose = vi.fn();
    const session = new JsonRpcSession(socket, { onClose });
    const waiting = expect(session.request("a")).rejects.toBeInstanceOf(ConnectionLost);
    socket.endSocket(1012, "retry_after=2");
    await waiting;
    await expect(session.request("b")).rejects.toBeInstanceOf(ConnectionLost);
    session.close(1000, "again");
    expect(onClose).toHaveBeenCalledExactlyOnceWith(1012, "retry_after=2");
    expect(vi.getTimerCount()).toBe(0);
  });

  it("bounds unanswered requests and unsent bytes", async () => {
    const session = new JsonRpcSession(socket, { maxOutstanding: 1 });
    const first = session.request("a");
    await expect(session.request("b")).rejects.toBeInstanceOf(RequestTimeout);
    answer({ id: 1, result: 0 });
    await first;
    socket.bufferedAmount = 2 ** 21;
    await expect(session.request("c")).rejects.toBeInstanceOf(RequestTimeout);
    expect(sent).toHaveLength(1);
  });

  it("ends on a binary message", () => {
    const onClose = vi.fn();
    new JsonRpcSession(socket, { onClose });
    socket.deliver(new ArrayBuffer(1));
    expect(onClose).toHaveBeenCalledWith(4003, "binary message");
  });
});
