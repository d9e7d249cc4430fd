import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import type { JsonObject } from "../../sdk/jsonrpc/peer.ts";
import { ConnectionLost, RequestTimeout, RpcError } from "../../sdk/jsonrpc/session.ts";
import { Client } from "../../sdk/rois/client.ts";
import { engineOf } from "../../sdk/rois/discovery.ts";
import { RoISError } from "../../sdk/rois/errors.ts";
import { FakeGateway, Refusal } from "../support/fake_gateway.ts";

const ARM = "r/arm";
const unit = { component_ref: ARM, command_type: "start", arguments: [] };

let gateway: FakeGateway;
let client: Client;
let tokens: number;

beforeEach(async () => {
  vi.useFakeTimers();
  tokens = 0;
  gateway = new FakeGateway(["rois.stream", "signaling", "openrois.lease"])
    .on("openrois.lease.token", () => ({ token: `t${++tokens}`, grace_ms: 10_000 }))
    .on("rois.command.bind", () => ({}))
    .on("rois.command.release", () => ({}))
    .on("rois.command.execute", () => ({}));
  client = new Client("ws://test/", { webSocket: gateway.webSocket });
  await client.connect();
});

afterEach(() => {
  vi.useRealTimers();
});

async function cut(): Promise<void> {
  gateway.socket.endSocket(1006);
  await vi.advanceTimersByTimeAsync(2000);
}

const resumed = (more: JsonObject = {}): JsonObject => ({
  token: "next",
  grace_ms: 10_000,
  leases: [{ component_ref: ARM, epoch: 7 }],
  forgotten: [],
  ...more,
});

it("a release keeps the component bound for a running work", async () => {
  let finish = (): void => undefined;
  let work = Promise.resolve();
  await new Promise<void>((began) => {
    work = client.bound(ARM, () => {
      began();
      return new Promise<void>((resolve) => (finish = resolve));
    });
  });
  await client.bind(ARM);
  await client.release(ARM);
  expect(gateway.called("rois.command.release")).toEqual([]);
  finish();
  await work;
  expect(gateway.called("rois.command.release")).toEqual([{ component_ref: ARM }]);
});

describe("a lost connection", () => {
  it("is resumed, and the ends of its commands are reported", async () => {
    await client.bind(ARM);
    const [id = ""] = await client.execute([unit]);
    gateway.on("openrois.lease.resume", () => resumed());
    await cut();
    expect(gateway.called("openrois.lease.resume")).toEqual([{ token: "t1", command_ids: [id] }]);
    const ended = client.completed(id);
    gateway.notify("rois.command.completed", { command_id: id, status: "OK" });
    await expect(ended).resolves.toMatchObject({ status: "OK" });
    expect(gateway.called("rois.command.release")).toEqual([]);
    await cut();
    expect(gateway.called("openrois.lease.resume")[1]).toMatchObject({ token: "next" });
  });

  it("fails commands that the gateway does not know", async () => {
    const [id = ""] = await client.execute([unit]);
    gateway.on("openrois.lease.resume", () => resumed({ forgotten: [id] }));
    await cut();
    await expect(client.completed(id)).rejects.toBeInstanceOf(ConnectionLost);
    expect(gateway.called("rois.command.release")).toEqual([{ component_ref: ARM }]);
  });

  it("that cannot be resumed fails its commands", async () => {
    const [id = ""] = await client.execute([unit]);
    gateway.on("openrois.lease.resume", () => ({ return_code: "UNSUPPORTED" }));
    await cut();
    await expect(client.completed(id)).rejects.toBeInstanceOf(ConnectionLost);
    expect(tokens).toBe(2);
  });

  it("fails its commands after the time that a gateway needs to restart", async () => {
    const [id = ""] = await client.execute([unit]);
    const settled = vi.fn();
    client.completed(id).catch(settled);
    gateway.stop();
    await vi.advanceTimersByTimeAsync(29_000);
    expect(settled).not.toHaveBeenCalled();
    await vi.advanceTimersByTimeAsync(1000);
    expect(settled).toHaveBeenCalledExactlyOnceWith(expect.any(ConnectionLost));
  });

  it("that broke again before it was resumed is resumed by the newer token", async () => {
    await client.bind(ARM);
    const [id = ""] = await client.execute([unit]);
    gateway.on("openrois.lease.resume", () => resumed());
    gateway.on("rois.command.bind", () => {
      gateway.on("rois.command.bind", () => ({}));
      gateway.socket.endSocket(1006);
      return {};
    });
    await cut();
    await vi.advanceTimersByTimeAsync(2000);
    expect(gateway.called("openrois.lease.resume")).toEqual([
      { token: "t1", command_ids: [id] },
      { token: "next", command_ids: [id] },
    ]);
  });

  it.each([1011, 1012, 4000])("that was closed with %i is resumed", async (code) => {
    await client.bind(ARM);
    const [id = ""] = await client.execute([unit]);
    gateway.on("openrois.lease.resume", () => resumed());
    gateway.socket.endSocket(code, "no answer");
    await vi.advanceTimersByTimeAsync(2000);
    expect(gateway.called("openrois.lease.resume")).toEqual([{ token: "t1", command_ids: [id] }]);
    const ended = client.completed(id);
    gateway.notify("rois.command.completed", { command_id: id, status: "OK" });
    await expect(ended).resolves.toMatchObject({ status: "OK" });
  });

  it("that the client found silent is resumed", async () => {
    const [id = ""] = await client.execute([unit]);
    client.completed(id).catch(() => undefined);
    gateway.on("openrois.lease.resume", () => resumed());
    gateway.mute = true;
    const silent = gateway.socket;
    const searching = expect(client.search("")).rejects.toThrow();
    await vi.advanceTimersByTimeAsync(10_000);
    await searching;
    gateway.mute = false;
    await vi.advanceTimersByTimeAsync(2000);
    expect(gateway.socket).not.toBe(silent);
    expect(gateway.called("openrois.lease.resume")).toEqual([{ token: "t1", command_ids: [id] }]);
  });

  it("that another connection has resumed is not resumed again", async () => {
    const [id = ""] = await client.execute([unit]);
    const lost = expect(client.completed(id)).rejects.toBeInstanceOf(ConnectionLost);
    gateway.socket.endSocket(4409, "another connection has resumed this session");
    await vi.advanceTimersByTimeAsync(2000);
    await lost;
    expect(gateway.called("openrois.lease.resume")).toEqual([]);
    expect(tokens).toBe(2);
  });

  it("ends at once where the client is closed", async () => {
    const [id = ""] = await client.execute([unit]);
    const lost = expect(client.completed(id)).rejects.toBeInstanceOf(ConnectionLost);
    await client.close();
    await lost;
  });
});

describe("a gateway that was restarted", () => {
  const ends: { [id: string]: JsonObject } = {};
  const asked = (): unknown[] =>
    gateway.called("rois.command.get_command_result").map((each) => each["command_id"]);

  beforeEach(() => {
    gateway.on("openrois.lease.resume", () => ({ return_code: "UNSUPPORTED" }));
  });

  /** Answers what the journal knows: `completed` comes right behind, once. */
  function journal(code: string, status?: string): void {
    gateway.on("rois.command.get_command_result", ({ command_id = "" }) => {
      if (status !== undefined && ends[String(command_id)] === undefined) {
        ends[String(command_id)] = { command_id, status };
        queueMicrotask(() =>
          queueMicrotask(() => gateway.notify("rois.command.completed", { command_id, status })),
        );
      }
      return { return_code: code };
    });
  }

  it.each([
    ["OK", "OK"],
    ["OK", "ABORT"],
    ["ERROR", "ERROR"],
  ])("reports how each command ended: %s, %s", async (code, status) => {
    const ids = await client.execute([unit, unit]);
    const ended = Promise.all(ids.map((id) => client.completed(id)));
    journal(code, status);
    await cut();
    await expect(ended).resolves.toEqual(ids.map((command_id) => ({ command_id, status })));
    expect(new Set(asked())).toEqual(new Set(ids));
  });

  it.each(["BAD_PARAMETER", "OK", "ERROR"])("and does not know it: %s", async (code) => {
    const [id = ""] = await client.execute([unit]);
    const lost = expect(client.completed(id)).rejects.toBeInstanceOf(ConnectionLost);
    journal(code);
    await cut();
    await lost;
    expect(asked()).toEqual(code === "BAD_PARAMETER" ? [id] : [id, id]);
  });

  it.each([
    [3, { status: "ERROR" }, 4],
    [99, null, 6],
  ])(
    "and waits for another one that may be lost is asked again, %i times in vain",
    async (looks, end, times) => {
      const [id = ""] = await client.execute([unit]);
      const ended = client.completed(id);
      const settled = end
        ? expect(ended).resolves.toMatchObject(end)
        : expect(ended).rejects.toBeInstanceOf(ConnectionLost);
      gateway.on("rois.command.get_command_result", () => {
        if (asked().length > looks)
          queueMicrotask(() => gateway.notify("rois.command.completed", { command_id: id, ...end }));
        return { return_code: asked().length > looks ? "ERROR" : "TIMEOUT" };
      });
      await cut();
      await settled;
      expect(asked()).toHaveLength(times);
    },
  );

  it("and ends again is asked again", async () => {
    const [id = ""] = await client.execute([unit]);
    const ended = client.completed(id);
    gateway.on("rois.command.get_command_result", () => {
      journal("ERROR", "ERROR");
      gateway.socket.endSocket(1006);
      return {};
    });
    await cut();
    await vi.advanceTimersByTimeAsync(2000);
    await expect(ended).resolves.toMatchObject({ status: "ERROR" });
  });
});

describe("control", () => {
  const status = (state: string): JsonObject => ({
    component_ref: ARM,
    state,
    holder: "ann",
    epoch: 7,
    waiting: 0,
    position: 0,
  });

  const inLine = { ...status("HELD"), waiting: 1, position: 1 };

  it("of a free component is granted at once", async () => {
    gateway.on("openrois.lease.request", () => ({ lease: status("MINE"), request_id: "" }));
    await client.control.request(ARM);
    gateway.on("openrois.lease.resume", () => ({ return_code: "UNSUPPORTED" }));
    await cut();
    expect(gateway.called("rois.command.bind")).toEqual([{ component_ref: ARM }]);
  });

  it("is granted, and lost again when another application has it", async () => {
    gateway.on("openrois.lease.request", () => ({ lease: status("HELD"), request_id: "q" }));
    const asking = client.control.request(ARM);
    await vi.advanceTimersByTimeAsync(0);
    gateway.notify("openrois.lease.changed", { ...status("MINE"), reason: "granted" });
    await asking;
    gateway.notify("openrois.lease.changed", { ...status("HELD"), reason: "taken" });
    gateway.on("openrois.lease.resume", () => ({ return_code: "UNSUPPORTED" }));
    await cut();
    expect(gateway.called("rois.command.bind")).toEqual([]);
  });

  it("is declined", async () => {
    gateway.on("openrois.lease.request", () => ({ lease: status("HELD"), request_id: "q" }));
    gateway.on("openrois.lease.leave", () => ({}));
    const refused = expect(client.control.request(ARM)).rejects.toBeInstanceOf(RoISError);
    await vi.advanceTimersByTimeAsync(0);
    gateway.notify("openrois.lease.declined", { component_ref: ARM, request_id: "q", reason: "no" });
    await refused;
    expect(gateway.called("openrois.lease.leave")).toHaveLength(1);
    expect(gateway.called("rois.command.release")).toHaveLength(1);
  });

  it("is asked about when its own engine has changed, of those that are named", async () => {
    gateway.on("openrois.lease.request", () => ({ lease: inLine, request_id: "q" }));
    gateway.on("openrois.lease.query", () => ({ lease: inLine }));
    gateway.on("openrois.lease.leave", () => ({}));
    const asking = client.control.request(ARM);
    asking.catch(() => undefined);
    await vi.advanceTimersByTimeAsync(0);
    gateway.notify("openrois.directory.changed", { changed: ["elsewhere"] });
    await vi.advanceTimersByTimeAsync(0);
    expect(gateway.called("openrois.lease.query")).toEqual([]);
    gateway.notify("openrois.directory.changed", { gone: [engineOf(ARM)] });
    await vi.advanceTimersByTimeAsync(0);
    expect(gateway.called("openrois.lease.query")).toEqual([{ component_ref: ARM }]);
    await client.close();
  });

  it("is withdrawn when the gateway does not answer in time", async () => {
    let answer = (_: JsonObject): void => undefined;
    gateway.on("openrois.lease.request", () => new Promise<JsonObject>((resolve) => (answer = resolve)));
    gateway.on("openrois.lease.leave", () => ({}));
    const late = expect(client.control.request(ARM)).rejects.toBeInstanceOf(RequestTimeout);
    await vi.advanceTimersByTimeAsync(9000);
    gateway.notify("profile_changed", {});
    await vi.advanceTimersByTimeAsync(2000);
    await late;
    expect(gateway.called("openrois.lease.leave")).toHaveLength(1);
    expect(gateway.called("rois.command.release")).toHaveLength(1);
    answer({ lease: inLine, request_id: "q" });
    await vi.advanceTimersByTimeAsync(0);
    expect(gateway.called("openrois.lease.leave")).toHaveLength(2);
    expect(gateway.called("rois.command.release")).toHaveLength(2);
  });

  it("is not given back by a request without an answer where it is bound already", async () => {
    await client.bind(ARM);
    gateway.on("openrois.lease.request", () => new Promise<JsonObject>(() => undefined));
    gateway.on("openrois.lease.leave", () => ({}));
    const late = expect(client.control.request(ARM)).rejects.toBeInstanceOf(RequestTimeout);
    await vi.advanceTimersByTimeAsync(9000);
    gateway.notify("profile_changed", {});
    await vi.advanceTimersByTimeAsync(2000);
    await late;
    expect(gateway.called("openrois.lease.leave")).toHaveLength(1);
    expect(gateway.called("rois.command.release")).toEqual([]);
  });

  it("is not withdrawn where the request is refused", async () => {
    gateway.on("openrois.lease.request", () => ({ return_code: "UNSUPPORTED" }));
    gateway.on("openrois.lease.leave", () => ({}));
    await expect(client.control.request(ARM)).rejects.toBeInstanceOf(RoISError);
    expect(gateway.called("openrois.lease.leave")).toEqual([]);
  });

  it("is waited for when the holder declines, and granted when it is released", async () => {
    gateway.on("openrois.lease.request", () => ({ lease: inLine, request_id: "q" }));
    gateway.on("openrois.lease.query", () => ({ lease: inLine }));
    const asking = client.control.request(ARM, { wait: true });
    await vi.advanceTimersByTimeAsync(0);
    gateway.notify("openrois.lease.declined", { component_ref: ARM, request_id: "q", reason: "no" });
    await vi.advanceTimersByTimeAsync(0);
    gateway.notify("openrois.lease.changed", { ...status("MINE"), reason: "given back" });
    await asking;
  });

  it("is not waited for after leaving the line", async () => {
    gateway.on("openrois.lease.request", () => ({ lease: inLine, request_id: "q" }));
    gateway.on("openrois.lease.query", () => ({ lease: inLine }));
    gateway.on("openrois.lease.leave", ({ component_ref }) => {
      if (component_ref === ARM) gateway.on("openrois.lease.query", () => ({ lease: status("HELD") }));
      return {};
    });
    const refused = expect(client.control.request(ARM, { wait: true })).rejects.toBeInstanceOf(RoISError);
    await vi.advanceTimersByTimeAsync(0);
    await client.control.leave("r/other");
    await client.control.leave(ARM);
    await refused;
    expect(gateway.called("openrois.lease.leave")).toEqual([
      { component_ref: "r/other" },
      { component_ref: ARM },
    ]);
    expect(gateway.called("rois.command.release")).toEqual([]);
  });

  const declined = { component_ref: ARM, request_id: "q", reason: "it is gone" };

  it.each([
    ["openrois.lease.declined", declined, "is gone", (): JsonObject => ({ return_code: "UNSUPPORTED" })],
    [
      "openrois.lease.declined",
      declined,
      "was gone for a moment",
      (): JsonObject => ({ lease: status("FREE") }),
    ],
    ["rois.system.profile_changed", {}, "is not shown", (): JsonObject => ({ return_code: "UNSUPPORTED" })],
  ])("is not waited for after %s %o: it %s", async (method, params, _, answer) => {
    gateway.on("openrois.lease.request", () => ({ lease: inLine, request_id: "q" }));
    gateway.on("openrois.lease.query", answer);
    const refused = expect(client.control.request(ARM, { wait: true })).rejects.toBeInstanceOf(RoISError);
    await vi.advanceTimersByTimeAsync(0);
    gateway.notify(method, params);
    await refused;
  });

  it("keeps neither place nor lease at the gateway after a failed request", async () => {
    gateway.on("openrois.lease.request", () => ({ lease: inLine, request_id: "q" }));
    gateway.on("openrois.lease.query", () => {
      throw new Refusal(-32000, "too many requests");
    });
    for (const name of ["openrois.lease.leave", "rois.command.release"])
      gateway.on(name, () => ({ return_code: "ERROR" }));
    const refused = expect(client.control.request(ARM, { wait: true })).rejects.toBeInstanceOf(RpcError);
    await vi.advanceTimersByTimeAsync(0);
    gateway.notify("rois.system.profile_changed", {});
    await refused;
    const sent = gateway.calls.slice(-2).map(({ method, params }) => [method, params]);
    expect(sent).toEqual([
      ["openrois.lease.leave", { component_ref: ARM }],
      ["rois.command.release", { component_ref: ARM }],
    ]);
  });

  it("that was never waited for is not given back", async () => {
    gateway.on("openrois.lease.request", () => ({ return_code: "OUT_OF_RESOURCES" }));
    await expect(client.control.request(ARM)).rejects.toBeInstanceOf(RoISError);
    expect(gateway.called("openrois.lease.leave")).toEqual([]);
    expect(gateway.called("rois.command.release")).toEqual([]);
  });

  it("is requested, granted, declined and taken", async () => {
    for (const name of ["grant", "decline", "take"]) gateway.on(`openrois.lease.${name}`, () => ({}));
    gateway.on("openrois.lease.query", () => ({ lease: status("HELD") }));
    const asked = vi.fn();
    client.control.on("openrois.lease.requested", asked);
    const request = { component_ref: ARM, request_id: "q", subject: "bob", answer_ms: 30_000 };
    gateway.notify("openrois.lease.requested", request);
    expect(asked).toHaveBeenCalledExactlyOnceWith(request);
    await client.control.grant("q");
    await client.control.decline("q");
    await client.control.take(ARM);
    expect((await client.control.status(ARM))?.state).toBe("HELD");
  });

  it("stops everything", async () => {
    gateway.on("openrois.stop_all", () => ({ stopped: [ARM], failed: [] }));
    await expect(client.control.stopAll("r")).resolves.toEqual([ARM]);
    await expect(client.control.stopAll()).resolves.toEqual([ARM]);
    expect(gateway.called("openrois.stop_all")).toEqual([{ engine_id: "r" }, {}]);
  });

  it("names the STOP that it was told last when it hands a body back", async () => {
    gateway.on("openrois.lease.release_stop", () => ({}));
    gateway.on("openrois.lease.query", () => ({ lease: { stopped_by: "ann", stop_id: "1" } }));
    await client.control.status(ARM);
    await client.control.releaseStop("r");
    // One that was refused is asked for anew, whichever STOP holds.
    await client.control.releaseStop("r");
    gateway.notify("openrois.lease.stopped", { engine_id: "r", by: "bob", reason: "", stop_id: "2" });
    await client.control.releaseStop("r");
    expect(gateway.called("openrois.lease.release_stop")).toEqual([
      { engine_id: "r", stop_id: "1" },
      { engine_id: "r" },
      { engine_id: "r", stop_id: "2" },
    ]);
  });

  it("hands back what a person has stopped", async () => {
    const told: unknown[] = [];
    client.control.on("openrois.lease.stopped", (stopped) => told.push(stopped));
    gateway.on("openrois.lease.release_stop", () => ({}));
    const stopped = { engine_id: "r", by: "ann", reason: "r was stopped by ann" };
    gateway.notify("openrois.lease.stopped", stopped);
    await client.control.releaseStop("r");
    expect(gateway.called("openrois.lease.release_stop")).toEqual([{ engine_id: "r" }]);
    expect(told).toEqual([stopped]);
  });
});

describe("a part for a time", () => {
  const told = vi.fn();
  const change = (state: string, more: JsonObject = {}): void =>
    gateway.notify("openrois.lease.changed", { component_ref: ARM, state, reason: "so it is", ...more });
  const lend = (): void => change("HELD", { holder: "ann", return_ms: 20_000, return_position: 1 });
  const settle = (): Promise<unknown> => vi.advanceTimersByTimeAsync(0);

  beforeEach(() => {
    told.mockClear();
    for (const name of ["lent", "lost", "restored"] as const)
      client.on(name, (claim) => told(name, "error" in claim ? claim.error.reason : claim));
  });

  it("is borrowed for seconds or for one command, and given back whole", async () => {
    const lease = { component_ref: ARM, state: "MINE", lender: "night watch", return_ms: 20_000 };
    gateway.on("openrois.lease.borrow", () => ({ lease })).on("openrois.lease.give_back", () => ({}));
    expect(await client.control.borrow(ARM, { seconds: 20 })).toEqual(lease);
    await client.control.borrow(ARM, { forOneCommand: true });
    expect(gateway.called("openrois.lease.borrow")).toEqual([
      { component_ref: ARM, duration_ms: 20_000 },
      { component_ref: ARM, ends_with: "COMMAND" },
    ]);
    await client.control.giveBack(ARM);
    expect(gateway.called("openrois.lease.give_back")).toEqual([{ component_ref: ARM }]);
    gateway.on("openrois.lease.resume", () => ({ return_code: "UNSUPPORTED" }));
    await cut();
    expect(gateway.called("rois.command.bind")).toEqual([]);
  });

  it("is refused where its holder is of equal or higher rank, and then nothing is bound", async () => {
    gateway.on("openrois.lease.borrow", () => ({ return_code: "OUT_OF_RESOURCES" }));
    await expect(client.control.borrow(ARM)).rejects.toBeInstanceOf(RoISError);
    gateway.on("openrois.lease.resume", () => ({ return_code: "UNSUPPORTED" }));
    await cut();
    expect(gateway.called("rois.command.bind")).toEqual([]);
  });

  it("is given back when its answer comes after the client gave up", async () => {
    let answer = (_: JsonObject): void => undefined;
    gateway.on("openrois.lease.borrow", () => new Promise<JsonObject>((resolve) => (answer = resolve)));
    const late = expect(client.control.borrow(ARM)).rejects.toBeInstanceOf(RequestTimeout);
    await vi.advanceTimersByTimeAsync(9000);
    gateway.notify("profile_changed", {});
    await vi.advanceTimersByTimeAsync(2000);
    await late;
    answer({ lease: { component_ref: ARM, state: "MINE" } });
    await settle();
    expect(gateway.called("rois.command.release")).toEqual([{ component_ref: ARM }]);
  });

  it("is lent and comes back: it is told, and not bound again meanwhile", async () => {
    await client.bind(ARM);
    lend();
    expect(told.mock.calls).toEqual([
      ["lent", { kind: "binding", componentRef: ARM, holder: "ann", returnMs: 20_000 }],
    ]);
    lend();
    gateway.notify("rois.system.profile_changed", {});
    await vi.advanceTimersByTimeAsync(20_000);
    expect(gateway.called("rois.command.bind")).toHaveLength(1);
    change("MINE");
    expect(told.mock.calls.slice(1)).toEqual([["restored", { kind: "binding", componentRef: ARM }]]);
    change("HELD");
    expect(told.mock.calls.slice(2)).toEqual([["lost", "another application holds it now: so it is"]]);
  });

  it("that does not come back is lost where another application has it, and bound again where it is free", async () => {
    await client.bind(ARM);
    lend();
    change("FREE");
    await settle();
    expect(gateway.called("rois.command.bind")).toHaveLength(2);
    expect(told.mock.calls.map(([name]) => name)).toEqual(["lent", "restored"]);
    lend();
    change("HELD");
    await vi.advanceTimersByTimeAsync(20_000);
    expect(gateway.called("rois.command.bind")).toHaveLength(2);
    expect(told.mock.calls.map(([name]) => name)).toEqual(["lent", "restored", "lent", "lost"]);
  });

  it("that is lent is released, and does not come back then", async () => {
    await client.bind(ARM);
    lend();
    await client.release(ARM);
    expect(gateway.called("rois.command.release")).toEqual([{ component_ref: ARM }]);
    change("FREE");
    await settle();
    expect(gateway.called("rois.command.bind")).toHaveLength(1);
    expect(told.mock.calls.map(([name]) => name)).toEqual(["lent"]);
  });

  it("that is lent is bound again over a connection that does not go on where the former one ended", async () => {
    await client.bind(ARM);
    lend();
    gateway.on("openrois.lease.resume", () => ({ return_code: "UNSUPPORTED" }));
    await cut();
    expect(gateway.called("rois.command.bind")).toHaveLength(2);
    expect(told.mock.calls.map(([name]) => name)).toEqual(["lent", "restored"]);
  });
});
