import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import { Client } from "../../sdk/rois/client.ts";
import { ConnectionLost, RequestTimeout, RpcError } from "../../sdk/jsonrpc/session.ts";
import { InvalidMessage, RoISError } from "../../sdk/rois/errors.ts";
import type { ClientOptions } from "../../sdk/rois/link.ts";
import type { JsonObject } from "../../sdk/jsonrpc/peer.ts";
import { FakeGateway } from "../support/fake_gateway.ts";

declare module "../../sdk/rois/extension_methods.ts" {
  interface ExtensionMethods {
    strange: object;
    "another.extension": { params: { readonly of: string }; result: JsonObject };
  }
}

let gateway: FakeGateway;

const clientOf = (options: ClientOptions = {}): Client =>
  new Client("ws://test/", { webSocket: gateway.webSocket, ...options });

function controller(): { signal: AbortSignal; abort: () => void } {
  const controller = new AbortController();
  return { signal: controller.signal, abort: () => controller.abort(new Error("enough")) };
}

beforeEach(() => {
  vi.useFakeTimers();
  gateway = new FakeGateway();
});

afterEach(() => {
  vi.useRealTimers();
});

describe("connecting", () => {
  it("says connect, then hello, and then is connected", async () => {
    const client = clientOf();
    await client.connect();
    expect(gateway.calls.map((call) => call.method)).toEqual(["rois.system.connect", "openrois.hello"]);
    expect(gateway.called("openrois.hello")).toEqual([
      { version: "1", extensions: ["rois.stream", "signaling", "openrois.directory"] },
    ]);
    expect(client.state).toEqual({ name: "connected" });
    expect(client.extensions).toEqual(["rois.stream", "signaling"]);
    expect(gateway.socket.protocols).toEqual([]);
    await client.connect();
    expect(gateway.sockets).toHaveLength(1);
  });

  it("takes a gateway that does not know hello for one that speaks plain RoIS", async () => {
    gateway = new FakeGateway(null);
    const client = clientOf();
    await client.connect();
    expect(client.extensions).toBeNull();
    await expect(client.search()).resolves.toEqual([]);
  });

  it("offers a token as a subprotocol in a page, never in the URL", async () => {
    vi.stubGlobal("location", { href: "https://page.example.org/" });
    const client = clientOf({ token: "a.b.c\n" });
    await client.connect();
    expect(gateway.socket.protocols).toEqual(["openrois.v1", "openrois.bearer.a.b.c"]);
    expect(gateway.headers).toEqual({});
    expect(gateway.socket.url).toBe("ws://test/");
    vi.unstubAllGlobals();
  });

  it("shows a token in the header elsewhere", async () => {
    const client = clientOf({ token: "a.b.c\n" });
    await client.connect();
    expect(gateway.socket.protocols).toEqual([]);
    expect(gateway.headers).toEqual({ Authorization: "Bearer a.b.c" });
    expect(gateway.socket.url).toBe("ws://test/");
  });

  it("rejects a malformed token without repeating it", async () => {
    const client = clientOf({ token: "canary canary" });
    const states: unknown[] = [];
    client.on("state", (state) => states.push(state));
    void client.connect().catch(() => undefined);
    await vi.waitFor(() => expect(client.state.name).toBe("waiting"));
    expect(JSON.stringify(states)).toContain("the token must be one line");
    expect(JSON.stringify(states)).not.toContain("canary");
    await client.close();
  });

  it("shows the newest token at each connection, and when the gateway says that the present one ends", async () => {
    const tokens = ["a.b.1", "a.b.2", "a.b.3"];
    const client = clientOf({ token: () => tokens.shift() });
    await client.connect();
    expect(gateway.headers).toEqual({ Authorization: "Bearer a.b.1" });
    gateway.notify("openrois.auth.expiring", { seconds: 60 });
    await vi.waitFor(() => expect(gateway.called("openrois.auth.refresh")).toEqual([{ token: "a.b.2" }]));
    const states: string[] = [];
    client.on("state", (state) => states.push(state.name));
    gateway.socket.close(4401, "the token has expired");
    // The client may wait for a moment only.
    await vi.waitFor(() => expect(states).toContain("waiting"));
    client.retryNow();
    await vi.waitFor(() => expect(client.state.name).toBe("connected"));
    expect(gateway.headers).toEqual({ Authorization: "Bearer a.b.3" });
  });

  it.each(["a.b.c", () => "a.b.c"])("has one token and no other: %s", async (token) => {
    const client = clientOf({ token });
    await client.connect();
    gateway.notify("openrois.auth.expiring", { seconds: 60 });
    await vi.advanceTimersByTimeAsync(100);
    expect(gateway.called("openrois.auth.refresh")).toEqual([]);
  });

  it("disconnects and stays closed", async () => {
    const client = clientOf();
    await client.connect();
    await client.close();
    expect(gateway.calls.at(-1)?.method).toBe("rois.system.disconnect");
    expect(client.state).toEqual({ name: "closed" });
    await vi.advanceTimersByTimeAsync(60_000);
    expect(gateway.sockets).toHaveLength(1);
    await expect(client.search()).rejects.toBeInstanceOf(ConnectionLost);
  });

  it("throws at once for a malformed address and without a WebSocket", () => {
    expect(() => new Client("not an address", { webSocket: gateway.webSocket })).toThrow(TypeError);
    vi.stubGlobal("WebSocket", undefined);
    Reflect.deleteProperty(globalThis, "WebSocket");
    expect(() => new Client("ws://test/")).toThrow(/give the option webSocket, or use Node 22/);
    vi.unstubAllGlobals();
  });

  it("refuses a class in place of the function that opens a socket at once", () => {
    class Socket extends EventTarget {
      send(): void {}
    }
    class Empty {}
    // As a compiler for old browsers writes a class.
    function Compiled(): void {}
    Compiled.prototype.send = (): void => undefined;
    const wrong: [unknown, string][] = [
      [Socket, "not the class Socket"],
      [Empty, "not the class Empty"],
      [Compiled, "not the class Compiled"],
      [gateway.webSocket("ws://test/", []), "not object"],
      ["ws", "not string"],
      [null, "not null"],
    ];
    for (const [webSocket, told] of wrong) {
      const make = (): Client => new Client("ws://test/", { webSocket } as unknown as ClientOptions);
      expect(make, told).toThrow(TypeError);
      expect(make).toThrow(
        `webSocket must be a function such as (url, protocols) => new WebSocket(url, protocols), ${told}`,
      );
    }
    expect(
      () =>
        new Client("ws://test/", {
          webSocket: function open(url, protocols) {
            return gateway.webSocket(url, protocols);
          },
        }),
    ).not.toThrow();
  });

  it("can be given up", async () => {
    gateway.running = false;
    const client = clientOf();
    const closed = expect(client.connect()).rejects.toBeInstanceOf(ConnectionLost);
    await client.close();
    await closed;
    const { signal, abort } = controller();
    const aborted = expect(client.connect({ signal })).rejects.toThrow("enough");
    abort();
    await aborted;
    expect(client.state.name).toBe("closed");
    await expect(client.connect({ signal })).rejects.toThrow("enough");
    expect(vi.getTimerCount()).toBe(0);
  });
});

describe("operations", () => {
  it("return their out parameters", async () => {
    gateway
      .on("rois.system.get_profile", () => ({
        profile: { identifier: { code: "g" } },
        component_profiles: {},
      }))
      .on("rois.command.search", () => ({ component_ref_list: ["a/b"] }))
      .on("rois.query.query", () => ({ results: [{ name: "n", data_type_ref: "int", value: "1" }] }))
      .on("rois.command.get_command_result", () => ({}))
      .on("rois.command.bind", () => ({}))
      .on("rois.command.release", () => ({}));
    const client = clientOf();
    await client.connect();
    await expect(client.getProfile()).resolves.toEqual({
      profile: { identifier: { code: "g" } },
      component_profiles: {},
    });
    await expect(client.search("component_ref = 'a/b'")).resolves.toEqual(["a/b"]);
    await expect(client.query("q", "c")).resolves.toEqual([{ name: "n", data_type_ref: "int", value: "1" }]);
    await expect(client.getCommandResult("c1")).resolves.toEqual([]);
    await client.bind("a/b");
    await client.release("a/b");
    expect(gateway.calls.slice(2)).toEqual([
      { method: "rois.system.get_profile", params: { condition: "" } },
      { method: "rois.command.search", params: { condition: "component_ref = 'a/b'" } },
      { method: "rois.query.query", params: { query_type: "q", condition: "c" } },
      { method: "rois.command.get_command_result", params: { command_id: "c1" } },
      { method: "rois.command.bind", params: { component_ref: "a/b" } },
      { method: "rois.command.release", params: { component_ref: "a/b" } },
    ]);
  });

  it("throw what the engine refuses", async () => {
    gateway.on("rois.command.bind", () => ({ return_code: "OUT_OF_RESOURCES" }));
    gateway.on("rois.command.search", () => ({ return_code: 7 }));
    const client = clientOf();
    await client.connect();
    const refused = client.bind("a/b");
    await expect(refused).rejects.toBeInstanceOf(RoISError);
    await expect(refused).rejects.toMatchObject({
      returnCode: "OUT_OF_RESOURCES",
      method: "rois.command.bind",
      message: "rois.command.bind(a/b): OUT_OF_RESOURCES",
    });
    for (const method of ["rois.command.execute", "rois.query.query", "strange"])
      gateway.on(method, () => ({ return_code: "UNSUPPORTED", results: [] }));
    const start = (component_ref: string) => ({ component_ref, command_type: "start" });
    await expect(client.execute([start("a/b"), { command_list: [start("c/d")] }])).rejects.toThrow(
      /^rois.command.execute\(start of a\/b, start of c\/d\): UNSUPPORTED$/,
    );
    await expect(client.query("mood", "x".repeat(300))).rejects.toThrow(
      /^rois.query.query\(mood, x{194}\): UNS/,
    );
    await expect(client.call("strange", { command_unit_list: 7 })).rejects.toThrow(/^strange: UNSUPPORTED$/);
    // @ts-expect-error: it is declared nowhere
    await expect(client.call("unheard.of")).rejects.toMatchObject({ name: "RpcError", code: -32601 });
    const wrong = client.search();
    await expect(wrong).rejects.toBeInstanceOf(InvalidMessage);
    await expect(wrong).rejects.toThrow(/return_code must be one of OK, ERROR/);
    gateway.on("rois.command.search", () => ({ component_ref_list: ["a/b", 7] }));
    await expect(client.search()).rejects.toThrow(
      "rois.command.search: result.component_ref_list.1 must be text",
    );
  });

  it("pass on the gateway's reason", async () => {
    gateway.on("rois.command.bind", ({ component_ref }, request_id) => {
      // What fits no request, or no command, is passed over; the last one of a request counts.
      for (const params of [{}, { reason: 5 }, { reason: "no" }, { reason: "no", request_id: "x" }])
        gateway.notify("openrois.reason", params);
      gateway.notify("openrois.reason", { request_id: request_id + 1, reason: "of another" });
      gateway.notify("openrois.reason", { request_id, reason: "old" });
      gateway.notify("openrois.reason", { request_id, reason: `${String(component_ref)}\n\u0000is theirs` });
      return { return_code: "OUT_OF_RESOURCES" };
    });
    const client = clientOf();
    await client.connect();
    const refs = Array.from({ length: 60 }, (_, number) => `a/${number}`);
    const errors = await Promise.all(refs.map((ref) => client.bind(ref).catch((error: unknown) => error)));
    for (const [index, error] of errors.entries())
      expect(error).toMatchObject({
        reason: `a/${index} is theirs`,
        message: `rois.command.bind(a/${index}): OUT_OF_RESOURCES (a/${index} is theirs)`,
      });
    gateway.on("rois.command.bind", () => ({ return_code: "ERROR" }));
    await expect(client.bind("a/b")).rejects.toMatchObject({
      reason: "",
      message: "rois.command.bind(a/b): ERROR",
    });
  });

  it("are all there, under the names of the standard", async () => {
    const parameters = [{ name: "p", data_type_ref: "int", value: "1" }];
    gateway
      .on("rois.command.bind_any", () => ({ component_ref: "a/b" }))
      .on("rois.command.get_parameter", () => ({ parameters }))
      .on("rois.command.set_parameter", () => ({ command_id: "a/p1" }))
      .on("rois.event.get_event_detail", () => ({ results: parameters }))
      .on("rois.system.get_error_detail", () => ({ results: parameters }));
    const client = clientOf();
    await client.connect();
    await expect(client.bindAny("c")).resolves.toBe("a/b");
    await expect(client.getParameter("a/b")).resolves.toEqual(parameters);
    await expect(client.setParameter("a/b", parameters)).resolves.toBe("a/p1");
    gateway.notify("rois.command.completed", { command_id: "a/p1", status: "OK" });
    await expect(client.completed("a/p1")).resolves.toEqual({ command_id: "a/p1", status: "OK" });
    await expect(client.getEventDetail("a/e1")).resolves.toEqual(parameters);
    await expect(client.getErrorDetail("a/f1")).resolves.toEqual(parameters);
    expect(gateway.calls.slice(2)).toEqual([
      { method: "rois.command.bind_any", params: { condition: "c" } },
      { method: "rois.command.get_parameter", params: { component_ref: "a/b" } },
      { method: "rois.command.set_parameter", params: { component_ref: "a/b", parameters } },
      { method: "rois.event.get_event_detail", params: { event_id: "a/e1" } },
      { method: "rois.system.get_error_detail", params: { error_id: "a/f1" } },
    ]);
  });

  it("are typed by their names", async () => {
    gateway.on("rois.command.search", () => ({ component_ref_list: ["a/b"] }));
    gateway.on("another.extension", () => ({ anything: 1 }));
    const client = clientOf();
    await client.connect();
    const { component_ref_list: refs } = await client.call("rois.command.search", { condition: "" });
    const typed: readonly string[] | undefined = refs;
    expect(typed).toEqual(["a/b"]);
    await client.call("rois.command.search");
    expect(await client.call("another.extension", { of: "mine" })).toEqual({
      return_code: "OK",
      anything: 1,
    });
    // @ts-expect-error: bind needs a component
    await expect(client.call("rois.command.bind")).rejects.toBeInstanceOf(RpcError);
    // @ts-expect-error: a condition is text
    await client.call("rois.command.search", { condition: 7 });
  });
});

describe("commands", () => {
  const unit = { component_ref: "a/b", command_type: "start" };

  it("get ids, also inside concurrent items, and are awaited by them", async () => {
    gateway.on("rois.command.execute", () => ({}));
    const client = clientOf();
    await client.connect();
    const ids = await client.execute([
      { ...unit, command_id: "mine" },
      { command_list: [unit, unit], delay_time: 5 },
    ]);
    expect(ids[0]).toBe("mine");
    expect(new Set(ids).size).toBe(3);
    expect(gateway.called("rois.command.execute")[0]).toEqual({
      command_unit_list: [
        { ...unit, command_id: "mine" },
        {
          command_list: [
            { ...unit, command_id: ids[1] },
            { ...unit, command_id: ids[2] },
          ],
          delay_time: 5,
        },
      ],
    });
    gateway.notify("rois.command.completed", { command_id: "mine", status: "OK" });
    await expect(client.completed("mine")).resolves.toEqual({ command_id: "mine", status: "OK" });
    const later = client.completed(ids[2] ?? "");
    gateway.notify("rois.command.completed", { command_id: ids[2] ?? "", status: "ABORT" });
    await expect(later).resolves.toMatchObject({ status: "ABORT" });
  });

  it("may complete together with their acceptance", async () => {
    gateway.on("rois.command.execute", () => {
      queueMicrotask(() => gateway.notify("rois.command.completed", { command_id: "quick", status: "OK" }));
      return {};
    });
    const client = clientOf();
    await client.connect();
    await client.execute([{ ...unit, command_id: "quick" }]);
    await expect(client.completed("quick")).resolves.toMatchObject({ status: "OK" });
  });

  it("are waited for with a time limit", async () => {
    gateway.on("rois.command.execute", () => ({}));
    const client = clientOf({ idleProbe: 1e6 });
    await client.connect();
    const [id = ""] = await client.execute([unit]);
    const waiting = expect(client.completed(id, 500)).rejects.toBeInstanceOf(RequestTimeout);
    await vi.advanceTimersByTimeAsync(500);
    await waiting;
  });

  it("fail with the connection, and are dropped when refused", async () => {
    gateway.on("rois.command.execute", () => ({}));
    const client = clientOf();
    await client.connect();
    const [id = ""] = await client.execute([unit]);
    const waiting = expect(client.completed(id)).rejects.toBeInstanceOf(ConnectionLost);
    gateway.stop();
    await waiting;
    await expect(client.completed(id)).rejects.toBeInstanceOf(ConnectionLost);
    await expect(client.execute([unit])).rejects.toBeInstanceOf(ConnectionLost);
  });

  it("that have ended are remembered in a bounded number, those that run all", async () => {
    gateway.on("rois.command.execute", () => ({}));
    const client = clientOf({ idleProbe: 1e6 });
    await client.connect();
    const [running = ""] = await client.execute([unit]);
    const end = (command_id: string): void =>
      gateway.notify("rois.command.completed", { command_id, status: "OK" });
    for (let count = 0; count <= 1024; count++) end(`c${count}`);
    await expect(client.completed("c1")).resolves.toMatchObject({ status: "OK" });
    const forgotten = expect(client.completed("c0", 500)).rejects.toBeInstanceOf(RequestTimeout);
    await vi.advanceTimersByTimeAsync(500);
    await forgotten;
    end(running);
    await expect(client.completed(running)).resolves.toMatchObject({ status: "OK" });
  });
});

describe("events", () => {
  const event = (subscribe_id: string) => ({ event_id: "e/1", event_type: "t", subscribe_id });

  it("reach the listener of their subscription, until it is cancelled", async () => {
    gateway
      .on("rois.event.subscribe", () => ({ subscribe_id: "s/1" }))
      .on("rois.event.unsubscribe", () => ({}));
    const client = clientOf();
    await client.connect();
    const heard = vi.fn();
    const subscription = await client.subscribe("t", "c", heard);
    gateway.notify("rois.event.notify_event", event("s/1"));
    gateway.notify("rois.event.notify_event", event("s/other"));
    expect(heard).toHaveBeenCalledExactlyOnceWith({ ...event("s/1"), expire: "", results: [] });
    await subscription.cancel();
    gateway.notify("rois.event.notify_event", event("s/1"));
    expect(heard).toHaveBeenCalledOnce();
    expect(gateway.called("rois.event.unsubscribe")).toEqual([{ subscribe_id: "s/1" }]);
  });

  it("come again after a reconnect and after the engines have changed", async () => {
    let count = 0;
    gateway
      .on("rois.event.subscribe", () => ({ subscribe_id: `s/${++count}` }))
      .on("rois.event.unsubscribe", () => ({}));
    const client = clientOf();
    await client.connect();
    const heard = vi.fn();
    await client.subscribe("t", "c", heard);
    gateway.socket.endSocket(1006);
    await vi.advanceTimersByTimeAsync(1000);
    gateway.notify("rois.event.notify_event", event("s/1"));
    expect(heard).not.toHaveBeenCalled();
    gateway.notify("rois.event.notify_event", event("s/2"));
    expect(heard).toHaveBeenCalledTimes(1);
    gateway.notify("rois.system.profile_changed", {});
    await vi.advanceTimersByTimeAsync(1);
    gateway.notify("rois.event.notify_event", event("s/3"));
    expect(heard).toHaveBeenCalledTimes(2);
    expect(gateway.called("rois.event.unsubscribe")).toEqual([{ subscribe_id: "s/2" }]);
  });

  it("and faults, profile changes and foreign notifications reach their listeners, even past one that throws", async () => {
    const client = clientOf();
    await client.connect();
    const failing = vi.spyOn(console, "error").mockImplementation(() => undefined);
    const heard = vi.fn();
    client.on("fault", () => {
      throw new Error("mine");
    });
    client.on("fault", heard);
    client.on("profile_changed", heard);
    const stop = client.on("notification", heard);
    gateway.notify("rois.system.notify_error", { error_id: "e", error_type: "USER_DEFINED_ERROR" });
    gateway.notify("rois.system.profile_changed", {});
    const dropped = vi.fn();
    client.on("dropped", dropped);
    gateway.notify("openrois.events_dropped", { count: 3 });
    expect(dropped).toHaveBeenCalledExactlyOnceWith(3);
    gateway.notify("foreign.thing", { a: 1 });
    expect(heard).toHaveBeenCalledTimes(6);
    expect(heard).toHaveBeenLastCalledWith({
      kind: "notification",
      method: "foreign.thing",
      params: { a: 1 },
    });
    expect(failing).toHaveBeenCalledOnce();
    stop();
    gateway.notify("foreign.thing", {});
    expect(heard).toHaveBeenCalledTimes(6);
    failing.mockRestore();
  });

  it("and invalid messages are reported and ignored", async () => {
    const client = clientOf();
    await client.connect();
    const heard = vi.fn();
    const invalid = vi.fn();
    for (const name of ["completed", "event", "fault", "notification"] as const) client.on(name, heard);
    client.on("invalid", invalid);
    gateway.notify("rois.command.completed", { command_id: "c", status: "DONE" });
    gateway.notify("rois.event.notify_event", { ...event("s/1"), results: [{ name: "n", value: 1 }] });
    gateway.notify("rois.system.notify_error", { error_id: 7, error_type: "USER_DEFINED_ERROR" });
    expect(heard).not.toHaveBeenCalled();
    expect(invalid.mock.calls.map(([what]) => what)).toEqual([
      "rois.command.completed: params.status must be one of OK, ERROR, ABORT, OUT_OF_RESOURCES, TIMEOUT",
      "rois.event.notify_event: params.results.0.data_type_ref must be text",
      "rois.system.notify_error: params.error_id must be text",
    ]);
  });
});
