import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import { Backoff } from "../../sdk/rois/backoff.ts";
import { Client } from "../../sdk/rois/client.ts";
import { gatewayUrl } from "../../sdk/rois/connection.ts";
import type { ConnectionState } from "../../sdk/rois/connection.ts";
import type { ClientOptions } from "../../sdk/rois/link.ts";
import { FakeGateway, FakeSocket, Refusal } from "../support/fake_gateway.ts";

let gateway: FakeGateway;
let states: ConnectionState[];

/** The waits lie at the upper end, so that times can be told exactly. */
const steady = { random: (): number => 1 };

function start(options: ClientOptions = {}): Client {
  const client = new Client("ws://test/", { webSocket: gateway.webSocket, backoff: steady, ...options });
  states = [];
  client.on("state", (state) => states.push(state));
  client.connect().catch(() => undefined);
  return client;
}

beforeEach(() => {
  vi.useFakeTimers({ now: 1_000_000 });
  gateway = new FakeGateway();
});

afterEach(() => {
  vi.useRealTimers();
});

describe("reconnecting", () => {
  it("waits longer each time, up to a limit, until the gateway is there", async () => {
    gateway.running = false;
    const client = start();
    await vi.advanceTimersByTimeAsync(0);
    const waits: number[] = [];
    for (let attempt = 1; attempt <= 10; attempt++) {
      if (client.state.name !== "waiting") throw new Error(client.state.name);
      expect(client.state.attempt).toBe(attempt);
      waits.push(Math.round(client.state.retryAt - Date.now()));
      await vi.advanceTimersByTimeAsync(Math.ceil(client.state.retryAt - Date.now()));
    }
    expect(waits).toEqual([500, 750, 1125, 1688, 2531, 3797, 5695, 8543, 10_000, 10_000]);
    gateway.running = true;
    await vi.advanceTimersByTimeAsync(10_000);
    expect(client.state).toEqual({ name: "connected" });
  });

  it("comes back by itself, and says why it was away", async () => {
    const client = start();
    await vi.advanceTimersByTimeAsync(0);
    gateway.socket.endSocket(1006);
    expect(client.state).toMatchObject({ name: "waiting", attempt: 1, reason: "closed (1006)" });
    await vi.advanceTimersByTimeAsync(500);
    expect(states.map((state) => state.name)).toEqual([
      "connecting",
      "connected",
      "waiting",
      "connecting",
      "connected",
    ]);
    expect(gateway.called("rois.system.connect")).toHaveLength(2);
  });

  it("counts anew after a connection that lasted", async () => {
    const client = start();
    await vi.advanceTimersByTimeAsync(0);
    gateway.socket.endSocket(1006);
    await vi.advanceTimersByTimeAsync(500);
    gateway.socket.endSocket(1006);
    expect(client.state).toMatchObject({ attempt: 2 });
    await vi.advanceTimersByTimeAsync(750);
    await vi.advanceTimersByTimeAsync(10_000);
    gateway.socket.endSocket(1006);
    expect(client.state).toMatchObject({ attempt: 1 });
  });

  it("obeys a gateway that says when it will be back", async () => {
    const client = start();
    await vi.advanceTimersByTimeAsync(0);
    gateway.socket.endSocket(1012, "retry_after=7");
    if (client.state.name !== "waiting") throw new Error(client.state.name);
    expect(client.state.retryAt - Date.now()).toBeGreaterThan(7000);
    expect(client.state.retryAt - Date.now()).toBeLessThanOrEqual(7500);
  });

  it("does not wait when there is reason to try now", async () => {
    const client = start();
    client.retryNow();
    await vi.advanceTimersByTimeAsync(0);
    gateway.socket.endSocket(1012, "retry_after=60");
    client.retryNow();
    await vi.advanceTimersByTimeAsync(0);
    expect(client.state).toEqual({ name: "connected" });
    expect(gateway.sockets).toHaveLength(2);
  });

  it("does not try again by itself while it is held", async () => {
    const client = start();
    await vi.advanceTimersByTimeAsync(0);
    client.hold();
    expect(client.state).toEqual({ name: "connected" });
    gateway.socket.endSocket(4401, "the token has ended");
    client.hold();
    expect(client.state).toMatchObject({ name: "waiting", retryAt: Infinity });
    await vi.advanceTimersByTimeAsync(600_000);
    expect(gateway.sockets).toHaveLength(1);
    client.retryNow();
    await vi.advanceTimersByTimeAsync(0);
    expect(client.state).toEqual({ name: "connected" });
  });

  it("gives up on a socket that does not open", async () => {
    const stuck: FakeSocket[] = [];
    const client = start({
      connectTimeout: 3000,
      webSocket: (url, protocols) => {
        stuck.push(new FakeSocket(url, protocols, () => undefined));
        return stuck.at(-1) as FakeSocket;
      },
    });
    await vi.advanceTimersByTimeAsync(3000);
    expect(client.state).toMatchObject({ name: "waiting", reason: "the gateway did not answer in time" });
    expect(stuck[0]?.readyState).toBe(3);
    await vi.advanceTimersByTimeAsync(500);
    expect(stuck).toHaveLength(2);
    stuck[0]?.open();
    expect(client.state.name).toBe("connecting");
  });

  it("says why there is no connection, where the socket does", async () => {
    const sockets: FakeSocket[] = [];
    const client = start({
      webSocket: (url, protocols) => {
        sockets.push(new FakeSocket(url, protocols, () => undefined));
        return sockets.at(-1) as FakeSocket;
      },
    });
    sockets[0]?.fail("connect ECONNREFUSED 127.0.0.1:8765");
    sockets[0]?.endSocket(1006);
    expect(client.state).toMatchObject({
      name: "waiting",
      attempt: 1,
      reason: "connect ECONNREFUSED 127.0.0.1:8765",
    });
    await vi.advanceTimersByTimeAsync(500);
    expect(sockets).toHaveLength(2);
    await client.close();
  });

  it("tries again after a handshake that fails, whatever the reason", async () => {
    gateway.on("rois.system.connect", () => ({ return_code: "ERROR" }));
    const client = start();
    await vi.advanceTimersByTimeAsync(0);
    expect(client.state).toMatchObject({ name: "waiting", reason: "rois.system.connect: ERROR" });
    gateway.on("rois.system.connect", () => ({}));
    gateway.on("openrois.hello", () => {
      throw new Refusal(-32603, "broken");
    });
    await vi.advanceTimersByTimeAsync(500);
    expect(client.state).toMatchObject({ name: "waiting", attempt: 2 });
    gateway.on("openrois.hello", () => ({ extensions: [] }));
    await vi.advanceTimersByTimeAsync(750);
    expect(client.state).toEqual({ name: "connected" });
    expect(gateway.sockets.filter((socket) => socket.readyState === 1)).toHaveLength(1);
  });

  it("reports an address that cannot be dialled", async () => {
    const client = start({
      webSocket: () => {
        throw new SyntaxError("bad address");
      },
    });
    expect(client.state).toMatchObject({ name: "waiting", reason: "bad address" });
    await client.close();
    expect(vi.getTimerCount()).toBe(0);
  });

  it("reports a function that returns no socket", async () => {
    const client = start({ webSocket: () => undefined as unknown as FakeSocket });
    expect(client.state).toMatchObject({
      name: "waiting",
      reason: expect.stringContaining("return a socket"),
    });
    await client.close();
  });

  it("closes while it dials, and hears nothing more", async () => {
    const client = start();
    const closing = client.close();
    await vi.advanceTimersByTimeAsync(60_000);
    await closing;
    expect(client.state).toEqual({ name: "closed" });
    expect(gateway.calls).toEqual([]);
  });

  it("asks a silent gateway for a sign of life, and leaves a dead one", async () => {
    const client = start({ idleProbe: 20_000, requestTimeout: 5000 });
    await vi.advanceTimersByTimeAsync(19_000);
    expect(gateway.called("rois.command.search")).toHaveLength(0);
    await vi.advanceTimersByTimeAsync(2000);
    expect(gateway.called("rois.command.search")).toHaveLength(1);
    expect(client.state.name).toBe("connected");
    gateway.mute = true;
    await vi.advanceTimersByTimeAsync(30_000);
    expect(states.find((state) => state.name === "waiting")).toMatchObject({ reason: "no answer" });
  });

  it.each([false, true])("connects anew on another network, dead: %s", async (dead) => {
    const client = start();
    await vi.advanceTimersByTimeAsync(10_000);
    gateway.mute = dead;
    client.networkChanged();
    client.networkChanged();
    await vi.advanceTimersByTimeAsync(2999);
    expect(client.state.name).toBe("connected");
    await vi.advanceTimersByTimeAsync(1);
    expect(client.state.name).toBe(dead ? "waiting" : "connected");
    gateway.mute = false;
    client.networkChanged();
    await vi.advanceTimersByTimeAsync(1);
    expect(client.state.name).toBe("connected");
  });
});

describe("gatewayUrl", () => {
  it.each(["", "127.0.0.1:8765", "localhost:8765", "ftp://127.0.0.1/", "ws://"])(
    "says that %j is none",
    (url) => {
      expect(() => gatewayUrl(url, undefined)).toThrow(
        new TypeError(`"${url}" is not the address of a gateway: give one such as ws://127.0.0.1:8765/`),
      );
    },
  );

  it.each([
    ["./", "http://127.0.0.1:8765/", "ws://127.0.0.1:8765/"],
    ["./", "https://robots.example/room/index.html#top", "wss://robots.example/room/"],
    ["ws://robot:8765/x", "http://page/", "ws://robot:8765/x"],
    ["http://robot:8765", undefined, "ws://robot:8765/"],
  ])("reads %s relative to %s", (url, base, expected) => {
    expect(gatewayUrl(url, base)).toBe(expected);
  });
});

describe("Backoff", () => {
  it("waits up to the end of each wait, by chance", () => {
    const chances = [0, 0.5, 0.999];
    const backoff = new Backoff({ random: () => chances.shift() ?? 0 });
    expect([backoff.next(), backoff.next(), backoff.next()]).toEqual([0, 375, 1124]);
    backoff.reset();
    expect(backoff.failures).toBe(0);
  });
});
