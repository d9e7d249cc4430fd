import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import type { JsonObject } from "../../sdk/jsonrpc/peer.ts";
import { Client, Move, Navigation, Reaction, RoISError, SpeechSynthesis } from "../../sdk/index.ts";
import type { Body, BodyLoss } from "../../sdk/index.ts";
import { bodiesIn } from "../../sdk/rois/body_directory.ts";
import { FakeGateway } from "../support/fake_gateway.ts";

/** The components behind the gateway by their engines, and what other applications hold. */
let engines: Record<string, string[]>;
let taken: Set<string>;
/** What this client holds. */
let held: Set<string>;
let gateway: FakeGateway;
let client: Client;

const refOf = (engine: string, code: string): string => `${engine}/${code.toLowerCase()}`;

function profile(): JsonObject {
  const below = Object.entries(engines).map(([engine, codes]) => ({
    identifier: { code: engine },
    component_ids: codes.map((code) => refOf(engine, code)),
  }));
  const components = Object.entries(engines).flatMap(([engine, codes]) =>
    codes.map((code): [string, JsonObject] => [
      refOf(engine, code),
      {
        identifier: { code, authority: "OMG" },
        name: code,
        function: code === "Ear" ? "sensing" : "actuation",
      },
    ]),
  );
  return {
    profile: {
      identifier: { code: "gateway" },
      sub_profiles: below,
      component_ids: below.flatMap(({ component_ids }) => component_ids),
    },
    component_profiles: Object.fromEntries(components),
  };
}

function serve(extensions: string[] | null): void {
  gateway = new FakeGateway(extensions)
    .on("rois.system.get_profile", profile)
    .on("openrois.lease.token", () => ({ token: "t", grace_ms: 10_000 }))
    .on("openrois.lease.query", ({ component_ref: ref }) => ({
      lease: { component_ref: ref as string, state: taken.has(ref as string) ? "HELD" : "FREE" },
    }))
    .on("rois.command.bind", ({ component_ref: ref }) => {
      if (taken.has(ref as string)) return { return_code: "OUT_OF_RESOURCES" };
      held.add(ref as string);
      return {};
    })
    .on("rois.command.release", ({ component_ref: ref }) => {
      held.delete(ref as string);
      return {};
    });
  client = new Client("ws://test/", { webSocket: gateway.webSocket, backoff: { random: () => 1 } });
}

beforeEach(async () => {
  vi.useFakeTimers();
  engines = {
    robot: ["SpeechSynthesis", "Navigation", "Ear"],
    walker: ["Navigation", "SpeechSynthesis", "Reaction"],
  };
  taken = new Set();
  held = new Set();
  serve(["openrois.lease"]);
  await client.connect();
});

afterEach(async () => {
  await client.close();
  vi.useRealTimers();
});

async function settled(): Promise<void> {
  await vi.advanceTimersByTimeAsync(0);
}

describe("a body", () => {
  it("is the components of one engine, bound in sorted order", async () => {
    const body = await client.body([SpeechSynthesis, Navigation]);
    expect(body.engineId).toBe("robot");
    expect(body.component(Navigation).componentRef).toBe("robot/navigation");
    expect(gateway.called("rois.command.bind").map(({ component_ref: ref }) => ref)).toEqual([
      "robot/navigation",
      "robot/speechsynthesis",
    ]);
    await body.release();
    expect(held).toEqual(new Set());
    expect(body.get(Navigation)).toBeUndefined();
  });

  it("is another one where a part of the first is taken, and nothing of that is held", async () => {
    taken.add("robot/speechsynthesis");
    const body = await client.body([Navigation, SpeechSynthesis], { waitMs: 0 });
    expect(body.engineId).toBe("walker");
    expect(held).toEqual(new Set(["walker/navigation", "walker/speechsynthesis"]));
  });

  it("is not the same as another one of this client", async () => {
    const both = [await client.body([Navigation]), await client.body([Navigation])];
    expect(both.map(({ engineId }) => engineId)).toEqual(["robot", "walker"]);
    await expect(client.body([Navigation], { waitMs: 0 })).rejects.toThrow(
      "another body of this application",
    );
  });

  it("may be without what is optional, and one that has it comes first", async () => {
    const body = await client.body([Navigation], { optional: [Reaction, Move] });
    expect(body.engineId).toBe("walker");
    expect(body.get(Reaction)?.componentRef).toBe("walker/reaction");
    expect(body.get(Move)).toBeUndefined();
    expect(() => body.component(Move)).toThrow(
      "walker was reserved without urn:x-rois:def:component:OMG::Move",
    );
    await body.release();
    taken.add("walker/reaction");
    const without = await client.body([Navigation], { optional: [Reaction] });
    expect([without.engineId, without.get(Reaction)]).toEqual(["walker", undefined]);
  });

  it("is tried again until the wait is over, and says what refused", async () => {
    taken = new Set(["robot/navigation", "walker/navigation"]);
    const waiting = client
      .body([Navigation, SpeechSynthesis], { waitMs: 1000 })
      .catch((error: unknown) => error);
    await vi.advanceTimersByTimeAsync(1000);
    const error = await waiting;
    expect(error).toBeInstanceOf(RoISError);
    expect((error as RoISError).returnCode).toBe("OUT_OF_RESOURCES");
    expect((error as RoISError).reason).toMatch(
      /^no body with Navigation and SpeechSynthesis is free: robot: rois.command.bind.*; walker: rois.command.bind/,
    );
    // At 0, 100, 250, 475, 813 (rounded) and 1000 ms, of two bodies each.
    expect(gateway.called("rois.command.bind")).toHaveLength(12);
    expect(gateway.called("rois.system.get_profile")).toHaveLength(1);
    expect(held).toEqual(new Set());
  });

  it("is had as soon as one is given back, or comes", async () => {
    taken = new Set(["robot/navigation", "walker/navigation"]);
    const first = client.body([Navigation]);
    await vi.advanceTimersByTimeAsync(500);
    taken.delete("walker/navigation");
    await vi.advanceTimersByTimeAsync(1000);
    expect((await first).engineId).toBe("walker");
    const second = client.body([Move]);
    await vi.advanceTimersByTimeAsync(500);
    engines["cart"] = ["Move"];
    await vi.advanceTimersByTimeAsync(1000);
    expect((await second).engineId).toBe("cart");
  });

  it("that does not exist is refused with those that do", async () => {
    await expect(client.body([Move], { waitMs: 0 })).rejects.toMatchObject({
      returnCode: "UNSUPPORTED",
      reason:
        "there is no body with Move; there are: robot (Ear, Navigation, SpeechSynthesis); walker (Navigation, Reaction, SpeechSynthesis)",
    });
    await expect(client.body([])).rejects.toThrow(RangeError);
    await expect(client.body([Move], { optional: [Move] })).rejects.toThrow("Move: named twice");
  });
});

describe("a body that is lost", () => {
  let body: Body;
  let losses: BodyLoss[];

  beforeEach(async () => {
    losses = [];
    client.on("body_lost", (loss) => losses.push(loss));
    body = await client.body([Navigation, SpeechSynthesis], { optional: [Reaction] });
  });

  const take = (ref: string): void => {
    held.delete(ref);
    gateway.notify("openrois.lease.changed", {
      component_ref: ref,
      state: "HELD",
      reason: "an administrator has taken it",
    });
  };

  it("is released whole when another application has a part of it", async () => {
    take("walker/navigation");
    await settled();
    expect(losses).toMatchObject([{ engineId: "walker", componentRef: "walker/navigation" }]);
    expect(body.error?.message).toContain("an administrator has taken it");
    expect(held).toEqual(new Set());
    await body.release();
    expect(losses).toHaveLength(1);
  });

  it("loses an optional part alone", async () => {
    take("walker/reaction");
    await settled();
    expect([losses, body.error, body.get(Reaction)]).toEqual([[], null, undefined]);
    expect(held).toEqual(new Set(["walker/navigation", "walker/speechsynthesis"]));
  });

  it("survives a lost connection, unless another application has a part of it then", async () => {
    gateway.on("openrois.lease.resume", () => ({ return_code: "UNSUPPORTED" }));
    gateway.socket.endSocket(1006);
    held.clear();
    await vi.advanceTimersByTimeAsync(2000);
    expect([losses, body.error]).toEqual([[], null]);
    expect(held.size).toBe(3);
    gateway.socket.endSocket(1006);
    held.clear();
    taken.add("walker/speechsynthesis");
    await vi.advanceTimersByTimeAsync(2000);
    expect(losses).toMatchObject([{ componentRef: "walker/speechsynthesis" }]);
    expect(held).toEqual(new Set());
  });

  it("is lost with the client", async () => {
    await client.close();
    expect(body.error?.message).toBe("the client is closed");
  });
});

describe("bodies", () => {
  it("are listed with what they can do and whether they are free", async () => {
    taken.add("walker/reaction");
    const [robot, walker] = await client.bodies();
    expect(robot).toMatchObject({ engineId: "robot", free: true });
    expect(robot?.components.map(({ componentRef, free }) => [componentRef, free])).toEqual([
      ["robot/ear", true],
      ["robot/navigation", true],
      ["robot/speechsynthesis", true],
    ]);
    expect(walker?.free).toBe(false);
    // What needs no reservation has no lease.
    expect(gateway.called("openrois.lease.query")).not.toContainEqual({ component_ref: "robot/ear" });
  });

  it("of a gateway without leases are free or not: it does not tell", async () => {
    await client.close();
    serve(null);
    await client.connect();
    expect((await client.bodies()).map(({ free }) => free)).toEqual([null, null]);
  });

  it("are engines that own components, the inner ones first", () => {
    const of = (code: string, own: string[], below: object[] = []): object => ({
      identifier: { code },
      component_ids: own,
      sub_profiles: below,
    });
    const arm = of("arm", ["arm/move"]);
    const robot = of("robot", ["robot/navigation", "arm/move"], [arm]);
    const site = of("site", ["robot/navigation", "arm/move"], [robot]);
    const tree = of("gateway", ["gateway/x", "robot/navigation", "arm/move"], [site]);
    const refs = ["arm/move", "robot/navigation", "gateway/x"];
    const component_profiles = Object.fromEntries(
      refs.map((ref) => [ref, { identifier: { code: ref }, name: ref }]),
    );
    const found = bodiesIn({ profile: tree, component_profiles } as never);
    expect(found.map(({ engineId, components }) => [engineId, ...components.keys()])).toEqual([
      ["arm", "arm/move"],
      ["robot", "arm/move", "robot/navigation"],
      ["gateway", "gateway/x"],
    ]);
    expect(bodiesIn({ profile: null, component_profiles: {} })).toEqual([]);
  });
});
