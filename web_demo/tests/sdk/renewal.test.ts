/** What an application has bound and subscribed outlives its session, and that of the engine. */

import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import type { JsonObject } from "../../sdk/jsonrpc/peer.ts";
import { ConnectionLost, RequestTimeout } from "../../sdk/jsonrpc/session.ts";
import { Client } from "../../sdk/rois/client.ts";
import type { Claim, LostClaim } from "../../sdk/rois/claims.ts";
import type { Subscription } from "../../sdk/rois/subscriptions.ts";
import { FakeGateway } from "../support/fake_gateway.ts";

const NAVIGATION = "robot/navigation";

let gateway: FakeGateway;
let client: Client;
let claims: [string, Claim][];
let subscribed: number;

const pass = (ms = 0): Promise<unknown> => vi.advanceTimersByTimeAsync(ms);
const answer = (method: string, return_code: string): unknown => gateway.on(method, () => ({ return_code }));
const count = (method: string): number => gateway.called(method).length;
const binding = { kind: "binding", componentRef: NAVIGATION };
const subscription = { kind: "subscription", eventType: "t", condition: "c" };

async function reconnect(): Promise<void> {
  gateway.socket.endSocket(1006);
  await pass(500);
}

async function engineChanged(): Promise<void> {
  gateway.notify("rois.system.profile_changed", {});
  await pass();
}

beforeEach(async () => {
  vi.useFakeTimers();
  gateway = new FakeGateway();
  subscribed = 0;
  gateway
    .on("rois.command.bind", () => ({}))
    .on("rois.command.release", () => ({}))
    .on("rois.event.subscribe", () => ({ subscribe_id: `s/${++subscribed}` }))
    .on("rois.event.unsubscribe", () => ({}));
  client = new Client("ws://test/", { webSocket: gateway.webSocket, backoff: { random: () => 1 } });
  claims = [];
  client.on("lost", (claim: LostClaim) => claims.push(["lost", claim]));
  client.on("restored", (claim) => claims.push(["restored", claim]));
  await client.connect();
});

afterEach(() => {
  vi.useRealTimers();
});

describe("bindings", () => {
  it("are restored before `connected` is emitted", async () => {
    await client.bind(NAVIGATION);
    const seen: unknown[] = [];
    client.on("state", ({ name }) => {
      if (name === "connected") seen.push(name, count("rois.command.bind"));
    });
    client.on("restored", ({ kind }) => seen.push(kind, client.state.name));
    await reconnect();
    // A listener of `restored` can use it.
    expect(seen).toEqual(["connected", 2, "binding", "connected"]);
    expect(claims).toEqual([["restored", binding]]);
  });

  it("that were released are not restored", async () => {
    await client.bind(NAVIGATION);
    await client.release(NAVIGATION);
    await reconnect();
    await engineChanged();
    expect(count("rois.command.bind")).toBe(1);
    expect(claims).toEqual([]);
  });

  it("of bindAny are restored too", async () => {
    gateway.on("rois.command.bind_any", () => ({ component_ref: NAVIGATION }));
    await client.bindAny();
    await reconnect();
    expect(gateway.called("rois.command.bind")).toEqual([{ component_ref: NAVIGATION }]);
  });

  it("that another application holds are reported once, and restored when it releases them", async () => {
    await client.bind(NAVIGATION);
    answer("rois.command.bind", "OUT_OF_RESOURCES");
    await reconnect();
    await engineChanged();
    expect(client.state.name).toBe("connected");
    expect(claims).toMatchObject([["lost", { ...binding, error: { returnCode: "OUT_OF_RESOURCES" } }]]);
    expect(vi.getTimerCount()).toBeGreaterThan(0);
    answer("rois.command.bind", "OK");
    // No notification reports that it was released.
    await pass(500);
    expect(claims.at(-1)).toEqual(["restored", binding]);
    const bound = count("rois.command.bind");
    await pass(60_000);
    expect(count("rois.command.bind")).toBe(bound);
  });

  it("that are missing are asked for less and less often, and no more when they are released", async () => {
    await client.bind(NAVIGATION);
    answer("rois.command.bind", "OUT_OF_RESOURCES");
    await engineChanged();
    const before = count("rois.command.bind");
    await pass(500 + 750 + 1125);
    expect(count("rois.command.bind")).toBe(before + 3);
    await client.release(NAVIGATION);
    await pass(60_000);
    expect(count("rois.command.bind")).toBe(before + 3);
  });

  it("that are released while others are being restored are given back", async () => {
    await client.bind(NAVIGATION);
    await client.bind("robot/speech");
    let bindSpeech = (): void => undefined;
    gateway.on("rois.command.bind", ({ component_ref }) =>
      component_ref === NAVIGATION ? {} : new Promise((resolve) => (bindSpeech = () => resolve({}))),
    );
    await reconnect();
    await expect(client.release(NAVIGATION)).rejects.toThrow(ConnectionLost);
    expect(gateway.called("rois.command.release")).toEqual([]);
    bindSpeech();
    await pass();
    expect(client.state.name).toBe("connected");
    expect(gateway.called("rois.command.release")).toEqual([{ component_ref: NAVIGATION }]);
  });

  it("come back with the engine", async () => {
    await client.bind(NAVIGATION);
    answer("rois.command.bind", "UNSUPPORTED");
    await engineChanged();
    expect(claims).toMatchObject([["lost", { ...binding, error: { returnCode: "UNSUPPORTED" } }]]);
    answer("rois.command.bind", "OK");
    await engineChanged();
    expect(claims).toHaveLength(2);
    await engineChanged();
    expect(claims).toHaveLength(2);
  });

  it("are not taken back by a release that came too early", async () => {
    await client.bind(NAVIGATION);
    let letIn = (): void => undefined;
    gateway.on("rois.command.bind", () => new Promise((resolve) => (letIn = () => resolve({}))));
    await engineChanged();
    await client.release(NAVIGATION);
    letIn();
    await pass();
    expect(count("rois.command.release")).toBe(2);
    expect(claims).toEqual([]);
  });

  it("leave no timer behind when the session ends while they are missing", async () => {
    await client.bind(NAVIGATION);
    gateway.on("rois.command.bind", () => new Promise(() => undefined));
    await engineChanged();
    await client.close();
    await pass();
    expect(vi.getTimerCount()).toBe(0);
  });

  it("end with the client", async () => {
    await client.bind(NAVIGATION);
    await client.close();
    await client.connect();
    expect(count("rois.command.bind")).toBe(1);
  });

  it("are kept when the session ends while they are made again", async () => {
    await client.bind(NAVIGATION);
    gateway.on("rois.command.bind", () => new Promise(() => undefined));
    await reconnect();
    gateway.socket.endSocket(1006);
    answer("rois.command.bind", "OK");
    await pass(1000);
    expect(client.state.name).toBe("connected");
    expect(claims).toEqual([["restored", binding]]);
  });
});

describe("subscriptions", () => {
  const event = (subscribe_id: string) => ({ event_id: "e/1", event_type: "t", subscribe_id });
  const heard = vi.fn();
  let heardOf: Subscription;

  beforeEach(async () => {
    heard.mockReset();
    heardOf = await client.subscribe("t", "c", heard);
  });

  it("come back, and say so", async () => {
    await reconnect();
    gateway.notify("rois.event.notify_event", event("s/1"));
    gateway.notify("rois.event.notify_event", event("s/2"));
    expect(heard).toHaveBeenCalledOnce();
    expect(claims).toEqual([["restored", subscription]]);
  });

  it("whose engine is away are reported once, and restored with it", async () => {
    answer("rois.event.subscribe", "UNSUPPORTED");
    await engineChanged();
    await engineChanged();
    expect(claims).toMatchObject([["lost", { ...subscription, error: { returnCode: "UNSUPPORTED" } }]]);
    gateway.on("rois.event.subscribe", () => ({ subscribe_id: "s/9" }));
    await engineChanged();
    gateway.notify("rois.event.notify_event", event("s/9"));
    expect(heard).toHaveBeenCalledOnce();
    expect(claims.at(-1)).toEqual(["restored", subscription]);
  });

  it("of a component that takes no new ones now are kept", async () => {
    answer("rois.event.subscribe", "ERROR");
    await engineChanged();
    gateway.notify("rois.event.notify_event", event("s/1"));
    expect(heard).toHaveBeenCalledOnce();
    expect(claims).toEqual([]);
  });

  it("hear the event that comes in one breath with the answer", async () => {
    gateway.on("rois.event.subscribe", () => ({ subscribe_id: "s/7" }));
    // Sockets of Node hand out all messages that came in together before any promise goes on.
    const socket = gateway.socket;
    const deliver = socket.deliver.bind(socket);
    socket.deliver = (data: unknown) => {
      deliver(data);
      if (String(data).includes("s/7") && String(data).includes("result")) {
        deliver(JSON.stringify({ jsonrpc: "2.0", method: "rois.event.notify_event", params: event("s/7") }));
      }
    };
    const early = vi.fn();
    await client.subscribe("t", "c2", early);
    expect(early).toHaveBeenCalledOnce();
  });

  it("hear an event once that comes by the old and by the new one", async () => {
    gateway.on("rois.event.subscribe", () => ({ subscribe_id: "s/8" }));
    const socket = gateway.socket;
    const deliver = socket.deliver.bind(socket);
    socket.deliver = (data: unknown) => {
      deliver(data);
      if (!String(data).includes("s/8") || !String(data).includes("result")) return;
      for (const id of ["s/1", "s/8"]) {
        deliver(JSON.stringify({ jsonrpc: "2.0", method: "rois.event.notify_event", params: event(id) }));
      }
    };
    await engineChanged();
    expect(heard).toHaveBeenCalledOnce();
  });

  it("that are cancelled while they are made again end on the gateway too", async () => {
    let letIn = (): void => undefined;
    gateway.on(
      "rois.event.subscribe",
      () => new Promise((resolve) => (letIn = () => resolve({ subscribe_id: "s/5" }))),
    );
    await engineChanged();
    await heardOf.cancel();
    letIn();
    await pass();
    expect(gateway.called("rois.event.unsubscribe")).toEqual([
      { subscribe_id: "s/1" },
      { subscribe_id: "s/5" },
      { subscribe_id: "s/1" },
    ]);
    gateway.notify("rois.event.notify_event", event("s/5"));
    expect(heard).not.toHaveBeenCalled();
  });

  it("are not made twice when the engines change while they are made", async () => {
    const waiting: (() => void)[] = [];
    gateway.on(
      "rois.event.subscribe",
      () => new Promise((resolve) => waiting.push(() => resolve({ subscribe_id: `s/${++subscribed}` }))),
    );
    const subscribing = client.subscribe("u", "c", heard);
    await engineChanged();
    expect(
      gateway.called("rois.event.subscribe").filter(({ event_type }) => event_type === "u"),
    ).toHaveLength(1);
    for (const answerIt of waiting) answerIt();
    await subscribing;
    expect(claims).toEqual([]);
  });

  it("whose session ends in one breath with the answer come back", async () => {
    const socket = gateway.socket;
    const deliver = socket.deliver.bind(socket);
    socket.deliver = (data: unknown) => {
      deliver(data);
      if (String(data).includes("s/2")) socket.endSocket(1006);
    };
    await client.subscribe("u", "c", heard);
    await pass(500);
    expect(client.state.name).toBe("connected");
    const made = gateway.called("rois.event.subscribe").map(({ event_type }) => event_type);
    expect(made).toEqual(["t", "u", "t", "u"]);
  });

  const GIVEN_UP: [string, JsonObject, () => Promise<unknown>, string, JsonObject][] = [
    ["bind", {}, () => client.bind("late/one"), "rois.command.release", { component_ref: "late/one" }],
    [
      "bound",
      {},
      () => client.bound("late/one", () => Promise.resolve()),
      "rois.command.release",
      { component_ref: "late/one" },
    ],
    [
      "bind_any",
      { component_ref: "late/one" },
      () => client.bindAny(),
      "rois.command.release",
      { component_ref: "late/one" },
    ],
    [
      "subscribe",
      { subscribe_id: "s/late" },
      () => client.subscribe("late", "c", () => undefined),
      "rois.event.unsubscribe",
      { subscribe_id: "s/late" },
    ],
  ];
  it.each(GIVEN_UP)("that come when %s had given up are given back", async (_, result, ask, undo, params) => {
    const waiting: (() => void)[] = [];
    const slow = () => new Promise<JsonObject>((resolve) => waiting.push(() => resolve(result)));
    for (const method of ["command.bind", "command.bind_any", "event.subscribe"])
      gateway.on(`rois.${method}`, slow);
    gateway.on("rois.command.release", () => ({}));
    const asking = expect(ask()).rejects.toBeInstanceOf(RequestTimeout);
    await pass(9000);
    gateway.notify("anything", {});
    await pass(1000);
    await asking;
    const before = gateway.called(undo).length;
    waiting[0]?.();
    await pass();
    expect(gateway.called(undo).slice(before)).toEqual([params]);
  });

  it("with an async listener that fails affect no other listener", async () => {
    const failing = vi.spyOn(console, "error").mockImplementation(() => undefined);
    gateway.on("rois.event.subscribe", () => ({ subscribe_id: "s/9" }));
    await client.subscribe("t", "c", () => Promise.reject(new Error("mine")) as unknown as undefined);
    gateway.notify("rois.event.notify_event", event("s/9"));
    await pass();
    expect(failing).toHaveBeenCalledOnce();
    failing.mockRestore();
  });

  it("with a listener that throws affect no other listener", async () => {
    const failing = vi.spyOn(console, "error").mockImplementation(() => undefined);
    heard.mockImplementation(() => {
      throw new Error("mine");
    });
    const other = vi.fn();
    gateway.on("rois.event.subscribe", () => ({ subscribe_id: "s/1" }));
    await client.subscribe("t", "c", other);
    gateway.notify("rois.event.notify_event", event("s/1"));
    expect(other).toHaveBeenCalledOnce();
    expect(failing).toHaveBeenCalledOnce();
    failing.mockRestore();
  });

  it("are made again one renewal at a time, however often the engines change", async () => {
    const waiting: (() => void)[] = [];
    gateway.on(
      "rois.event.subscribe",
      () => new Promise((resolve) => waiting.push(() => resolve({ subscribe_id: `s/${++subscribed}` }))),
    );
    for (let change = 0; change < 5; change++) await engineChanged();
    expect(waiting).toHaveLength(1);
    waiting[0]?.();
    await pass();
    expect(waiting).toHaveLength(2);
    waiting[1]?.();
    await pass();
    expect(waiting).toHaveLength(2);
    gateway.notify("rois.event.notify_event", event("s/3"));
    expect(heard).toHaveBeenCalledOnce();
    // None is left over at the gateway.
    expect(gateway.called("rois.event.unsubscribe")).toEqual([
      { subscribe_id: "s/1" },
      { subscribe_id: "s/2" },
    ]);
  });

  it("that hang delay no other claim", async () => {
    gateway.on("rois.event.subscribe", () => new Promise(() => undefined));
    await reconnect();
    expect(client.state.name).toBe("connected");
  });
});
