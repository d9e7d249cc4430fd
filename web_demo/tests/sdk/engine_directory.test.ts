/** The directory as a client knows it: read once, in pages, and then only what has changed. */

import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import { Client, Navigation, bodiesIn, bodiesOf } from "../../sdk/index.ts";
import type { ProfileChange } from "../../sdk/index.ts";
import { FakeDirectory } from "../support/fake_directory.ts";
import { FakeGateway } from "../support/fake_gateway.ts";

const NAME = "openrois.directory";

let gateway: FakeGateway;
let directory: FakeDirectory;
let client: Client;

beforeEach(async () => {
  vi.useFakeTimers();
  gateway = new FakeGateway(["rois.stream", NAME]);
  directory = new FakeDirectory(gateway, 2).put("a", ["Navigation"]).put("b", ["Navigation", "Reaction"]);
  gateway.on("rois.command.bind", () => ({})).on("rois.command.release", () => ({}));
  client = new Client("ws://test/", { webSocket: gateway.webSocket, backoff: { random: () => 1 } });
  await client.connect();
});

afterEach(async () => {
  await client.close();
  vi.useRealTimers();
});

/** What was asked about the directory since it was asked for last. */
function asked(): unknown[] {
  const told = gateway.calls.flatMap(({ method, params }) =>
    method.startsWith(`${NAME}.`)
      ? [params["after"] ?? params["engine_ids"] ?? params["component_refs"]]
      : [],
  );
  gateway.calls.length = 0;
  return told;
}

const ids = async (): Promise<string[]> => [...(await client.engines()).keys()].sort();

describe("the engines", () => {
  it("are asked for by the name of the extension", () => {
    expect(gateway.called("openrois.hello")).toMatchObject([
      { extensions: ["rois.stream", "signaling", NAME] },
    ]);
  });

  it("are listed once, in pages, and then only asked whether anything has changed", async () => {
    expect(await client.engines()).toEqual(directory.entries);
    expect(await client.engines()).toEqual(directory.entries);
    expect(asked()).toEqual(["", "b", []]);
  });

  it("are read where they have changed, and no others", async () => {
    await client.engines();
    asked();
    directory.put("a", ["Reaction"]).put("c").put("d").remove("b");
    directory.notify(["a", "c", "d"]);
    directory.notify([], ["b"]);
    expect(await client.engines()).toEqual(directory.entries);
    expect(asked()).toEqual([["a", "c", "d"], ["d"]]);
  });

  it("are as new as what was notified before the reply", async () => {
    await client.engines();
    asked();
    directory.before.push(() => {
      directory.put("c").remove("b");
      directory.notify(["c"], ["b"]);
    });
    expect(await client.engines()).toEqual(directory.entries);
    expect(asked()).toEqual([[], ["c", "b"]]);
  });

  it("that change while they are listed are not those of the list", async () => {
    directory.put("c").put("d");
    directory.before.push(
      () => undefined,
      () => {
        directory.remove("a").put("d", ["Reaction"]);
        directory.notify(["d"], ["a"]);
      },
    );
    expect(await client.engines()).toEqual(directory.entries);
  });

  it("that are gone after they were reported as others are absent", async () => {
    await client.engines();
    directory.notify(["b"]);
    directory.remove("b");
    expect(await ids()).toEqual(["a", "gateway"]);
  });

  it("are listed again where too much has changed to name it, also meanwhile", async () => {
    await client.engines();
    asked();
    directory.remove("a").put("x");
    directory.notify(["x"], [], 1);
    directory.before.push(() => directory.notify([], [], 7));
    expect(await client.engines()).toEqual(directory.entries);
    expect(asked()).toEqual(["", "", "gateway"]);
  });

  it("are listed again after a reconnect", async () => {
    await client.engines();
    directory.remove("a").put("x");
    gateway.socket.endSocket(1006);
    await vi.advanceTimersByTimeAsync(1000);
    asked();
    expect(await client.engines()).toEqual(directory.entries);
    expect(asked()).toEqual(["", "gateway"]);
  });

  it("that could not be read are read the next time", async () => {
    await client.engines();
    directory.put("a", ["Reaction"]);
    directory.notify(["a"]);
    directory.before.push(() => {
      throw new Error("too much to do");
    });
    await expect(client.engines()).rejects.toThrow("too much to do");
    expect(await client.engines()).toEqual(directory.entries);
  });

  it("of a list that does not go on are not asked for without end", async () => {
    gateway.on(`${NAME}.list`, () => ({ engines: [], next: "a" }));
    await client.engines();
    expect(asked()).toEqual(["", "a"]);
  });

  it("of a gateway of the base wire are for its profile to tell", async () => {
    await client.close();
    gateway = new FakeGateway(null);
    client = new Client("ws://test/", { webSocket: gateway.webSocket });
    await client.connect();
    await expect(client.engines()).rejects.toThrow("Method not found");
  });
});

describe("profiles", () => {
  /** Loads the profiles of the components with these references, and returns the names in them by their versions. */
  const load = async (...refs: string[]): Promise<Record<string, string>> => {
    const entries = [...directory.entries.values()].flatMap(({ components = [] }) => components);
    const wanted = refs.flatMap((ref) => entries.filter(({ component_ref }) => component_ref === ref));
    const profiles = await client.profiles(wanted);
    return Object.fromEntries([...profiles].map(([version, { name }]) => [version, name]));
  };

  it("are loaded once for each version, however many components have it", async () => {
    const both = { "v-Navigation": "Navigation", "v-Reaction": "Reaction" };
    expect(await load("a/navigation", "b/navigation", "b/reaction")).toEqual(both);
    expect(asked()).toEqual([["b/navigation", "b/reaction"]]);
    expect(await Promise.all([load("a/navigation"), load("a/navigation", "b/reaction")])).toEqual([
      { "v-Navigation": "Navigation" },
      both,
    ]);
    expect(asked()).toEqual([]);
  });

  it("for which there was no room are asked for again", async () => {
    const types = ["A", "B", "C", "D", "E"];
    directory.put("c", types);
    const loaded = await load(...types.map((type) => `c/${type.toLowerCase()}`));
    expect(Object.values(loaded)).toEqual(types);
    expect(asked()).toEqual([["c/a", "c/b", "c/c", "c/d", "c/e"], ["c/c", "c/d", "c/e"], ["c/e"]]);
  });

  it("for which there is never room are not asked for without end", async () => {
    gateway.on(`${NAME}.profiles`, ({ component_refs }) => ({ left: component_refs ?? [] }));
    expect(await load("a/navigation")).toEqual({});
  });

  it("that were not needed for long are dropped", async () => {
    const types = Array.from({ length: 1025 }, (_, number) => `T${number}`);
    directory = new FakeDirectory(gateway, 2000).put("c", types);
    expect(Object.keys(await load(...types.map((type) => `c/${type.toLowerCase()}`)))).toHaveLength(1025);
    asked();
    await load("c/t1", "c/t1024");
    expect(asked()).toEqual([]);
    await load("c/t0");
    expect(asked()).toEqual([["c/t0"]]);
  });

  it("are not those of another session", async () => {
    await load("a/navigation");
    gateway.socket.endSocket(1006);
    await vi.advanceTimersByTimeAsync(1000);
    asked();
    await load("a/navigation");
    expect(asked()).toEqual([["a/navigation"]]);
  });

  it("that are others by now are absent", async () => {
    const was = directory.entries.get("a")?.components ?? [];
    const now = was.map((each) => ({ ...each, profile_version: "v-2" }));
    directory.profiles.set("v-2", { identifier: { code: "Navigation" }, name: "another" });
    directory.entries.set("a", { engine_id: "a", parent_id: "gateway", version: "2", components: now });
    expect((await client.profiles(was)).size).toBe(0);
    expect((await client.profiles(now)).get("v-2")?.name).toBe("another");
  });
});

describe("a change", () => {
  let heard: ProfileChange[];

  beforeEach(() => {
    heard = [];
    client.on("profile_changed", (change) => heard.push(change));
  });

  const subscribe = async (...engineIds: string[]): Promise<void> => {
    let count = 0;
    gateway
      .on("rois.event.subscribe", ({ condition }) => ({ subscribe_id: `${condition}/${++count}` }))
      .on("rois.event.unsubscribe", () => ({}));
    for (const engineId of engineIds) await client.subscribe("t", engineId, () => undefined);
    gateway.calls.length = 0;
  };

  it("names the engines, or none where any may have changed", () => {
    directory.notify(["a"], ["b"]);
    directory.notify(["a"], [], 3);
    gateway.notify("rois.system.profile_changed", {});
    expect(heard).toEqual([
      { engineIds: new Set(["a", "b"]) },
      { engineIds: new Set() },
      { engineIds: new Set() },
    ]);
  });

  it("renews the subscriptions and bindings at these engines alone", async () => {
    await subscribe("a", "b");
    await client.bind("a/navigation");
    await client.bind("b/reaction");
    gateway.calls.length = 0;
    directory.notify(["b", "c"]);
    await vi.advanceTimersByTimeAsync(0);
    expect(gateway.called("rois.event.subscribe")).toMatchObject([{ condition: "b" }]);
    expect(gateway.called("rois.event.unsubscribe")).toEqual([{ subscribe_id: "b/2" }]);
    expect(gateway.called("rois.command.bind")).toEqual([{ component_ref: "b/reaction" }]);
  });

  it("of which not all is named renews everything, also beside one that is named", async () => {
    await subscribe("a", "b");
    directory.notify(["a"]);
    directory.notify(["b"], [], 1);
    directory.notify(["c"]);
    await vi.advanceTimersByTimeAsync(0);
    const renewed = gateway.called("rois.event.subscribe").map(({ condition }) => condition);
    expect(renewed.sort()).toEqual(["a", "a", "b"]);
  });

  it("that comes with another one is not lost", async () => {
    await subscribe("a", "b", "c");
    directory.notify(["a"]);
    directory.notify(["b"]);
    directory.notify(["c"]);
    await vi.advanceTimersByTimeAsync(0);
    expect(gateway.called("rois.event.subscribe").map(({ condition }) => condition)).toEqual(["a", "b", "c"]);
  });
});

describe("bodies", () => {
  it("are read from the directory, and no profile is", async () => {
    expect((await client.bodies()).map(({ engineId, free }) => [engineId, free])).toEqual([
      ["a", null],
      ["b", null],
    ]);
    const body = await client.body([Navigation]);
    expect(body.engineId).toBe("a");
    const another = client.body([Navigation]);
    expect((await another).engineId).toBe("b");
    expect(gateway.called("rois.system.get_profile")).toEqual([]);
  });

  it("that meet a condition are those of the profile", async () => {
    gateway.on("rois.system.get_profile", () => ({ profile: null, component_profiles: {} }));
    await expect(client.body([Navigation], { condition: "c", waitMs: 0 })).rejects.toThrow(
      "there is no body",
    );
    expect(gateway.called("rois.system.get_profile")).toEqual([{ condition: "c" }]);
  });

  it("are the same by directory and by profile", async () => {
    directory
      .put("gateway", ["Bell"], "")
      .put("site", [])
      .put("robot", ["Navigation", "Bell"], "site")
      .put("arm", ["Move"], "robot");
    const of = (code: string, component_ids: string[], sub_profiles: object[] = []): object => ({
      identifier: { code },
      component_ids,
      sub_profiles,
    });
    const arm = of("arm", ["arm/move"]);
    const robot = of("robot", ["robot/navigation", "robot/bell", "arm/move"], [arm]);
    const profile = of(
      "gateway",
      ["gateway/bell"],
      [of("site", [], [robot]), of("b", ["b/reaction", "b/navigation"]), of("a", ["a/navigation"])],
    );
    const entries = await client.engines();
    const component_profiles = Object.fromEntries(
      [...entries.values()].flatMap(({ components = [] }) =>
        components.map(({ component_ref, component_type, function: kind }) => [
          component_ref,
          { identifier: { code: component_type }, name: "", function: kind },
        ]),
      ),
    );
    const found = bodiesOf(entries);
    expect(found).toEqual(bodiesIn({ profile, component_profiles } as never));
    expect(found.map(({ engineId }) => engineId)).toEqual(["a", "b", "arm", "robot", "gateway"]);
    expect([...(found[3]?.components.keys() ?? [])]).toEqual(["arm/move", "robot/bell", "robot/navigation"]);
  });
});
