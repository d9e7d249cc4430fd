import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import { EntryTree } from "../../../app/inspector/entry_tree.ts";
import { ProfileLoader } from "../../../app/inspector/profile_loader.ts";
import { componentsOf, enginesOf, visibleRows } from "../../../app/inspector/profile_tree.ts";
import type { EngineNode } from "../../../app/inspector/profile_tree.ts";
import { Client } from "../../../sdk/index.ts";
import type { ComponentEntry, EngineEntry } from "../../../sdk/index.ts";
import { FakeDirectory } from "../../support/fake_directory.ts";
import { FakeGateway } from "../../support/fake_gateway.ts";

let gateway: FakeGateway;
let directory: FakeDirectory;
let client: Client;
let loader: ProfileLoader;
let loads: number;
let tree: EntryTree;

const settle = (): Promise<unknown> => vi.advanceTimersByTimeAsync(0);
const build = (): EngineNode[] => tree.build(directory.entries, loader);
const components = (engineId: string): readonly ComponentEntry[] =>
  directory.entries.get(engineId)?.components ?? [];
const entry = (engineId: string): EngineEntry => directory.entries.get(engineId) as EngineEntry;

beforeEach(async () => {
  vi.useFakeTimers();
  gateway = new FakeGateway(["openrois.directory"]);
  directory = new FakeDirectory(gateway)
    .put("robot", ["Navigation", "PersonDetection"])
    .put("hand", ["Move"], "robot")
    .put("avatar", ["Navigation"]);
  client = new Client("ws://test/", { webSocket: gateway.webSocket });
  loads = 0;
  loader = new ProfileLoader(client, () => (loads += 1));
  tree = new EntryTree();
  await client.connect();
});

afterEach(async () => {
  await client.close();
  vi.useRealTimers();
});

describe("EntryTree", () => {
  it("has every engine at its place, in the order of their ids, with the types of components", () => {
    const engines = build();
    expect(enginesOf(engines).map(({ id }) => id)).toEqual(["gateway", "avatar", "robot", "hand"]);
    expect(visibleRows(engines, () => true).map(({ id, level }) => `${level} ${id}`)).toEqual([
      "1 gateway",
      "2 avatar",
      "3 avatar/navigation",
      "2 robot",
      "3 robot/navigation",
      "3 robot/persondetection",
      "3 hand",
      "4 hand/move",
    ]);
    expect(visibleRows(engines, () => true, "sensing PersonDetection").map(({ id }) => id)).toEqual([
      "gateway",
      "robot",
      "robot/persondetection",
    ]);
  });

  it("shows one whose parent is not listed at the top", () => {
    directory.put("stray", ["Move"], "unheard of");
    expect(build().map(({ id }) => id)).toEqual(["gateway", "stray"]);
  });

  it("has what is in a profile once that is loaded, and keeps the nodes that have not changed", async () => {
    const before = new Map(componentsOf(build()).map((node) => [node.ref, node]));
    expect(visibleRows(build(), () => true, "is_Move")).toEqual([]);
    loader.want(components("hand"));
    await settle();
    const after = new Map(componentsOf(build()).map((node) => [node.ref, node]));
    expect(after.get("robot/navigation")).toBe(before.get("robot/navigation"));
    expect(after.get("hand/move")).toMatchObject({ isLoaded: true, profile: { name: "Move" } });
    expect(visibleRows(build(), () => true, "is_Move").at(-1)).toMatchObject({
      id: "hand/move",
      found: "is_Move",
    });
  });
});

describe("ProfileLoader", () => {
  const asked = (): unknown[] =>
    gateway.called("openrois.directory.profiles").map(({ component_refs: refs }) => refs);

  it("loads each version once, and what is wanted meanwhile after it", async () => {
    loader.want([...components("robot"), ...components("avatar")]);
    loader.want(components("hand"));
    await settle();
    loader.want(components("avatar"));
    await settle();
    expect(asked()).toEqual([["avatar/navigation", "robot/persondetection"], ["hand/move"]]);
    expect(loads).toBe(2);
  });

  it("does not ask without end for what is not there, and asks again when it is wanted again", async () => {
    const gone = components("hand");
    directory.remove("hand");
    loader.want(gone);
    await settle();
    expect([asked().length, loads]).toEqual([1, 0]);
    directory.put("hand", ["Move"], "robot");
    loader.want(gone);
    await settle();
    expect([asked().length, loads]).toEqual([2, 1]);
  });

  it("goes on after a request that failed", async () => {
    gateway.stop();
    loader.want(components("hand"));
    await settle();
    gateway.running = true;
    await vi.advanceTimersByTimeAsync(2000);
    loader.want(components("hand"));
    await settle();
    expect(loader.component("v-Move")?.name).toBe("Move");
  });

  it("keeps a bounded number of profiles, and those that are wanted", async () => {
    directory = new FakeDirectory(gateway, 2000).put("a", ["Move"]).put(
      "b",
      Array.from({ length: 1100 }, (_, number) => `T${number}`),
    );
    loader.want(components("a"));
    await settle();
    loader.want(components("b"));
    await settle();
    expect(loader.component("v-Move")).toBeUndefined();
    expect([loader.component("v-T0")?.name, loader.component("v-T1023")?.name]).toEqual(["T0", "T1023"]);
    expect(loader.component("v-T1024")).toBeUndefined();
  });

  it("loads the profile of the engine that is shown, and no other engine's", async () => {
    const hand = { identifier: { code: "hand", version: "2" }, component_ids: ["hand/move"] };
    const robot = { identifier: { code: "robot" }, sub_profiles: [hand] };
    const answer = {
      profile: { identifier: { code: "gateway" }, sub_profiles: [robot] },
      component_profiles: {},
    };
    gateway.on("rois.system.get_profile", () => answer);
    await loader.wantEngine(entry("hand"), "");
    await loader.wantEngine(entry("hand"), "");
    expect(loader.engine("hand")).toEqual(hand);
    expect([loader.engine("robot"), loads]).toEqual([null, 1]);
    directory.put("site_1", []).put("robot", [], "site_1");
    await loader.wantEngine(entry("robot"), "hand/move");
    await loader.wantEngine(entry("gateway"), "");
    await loader.wantEngine(entry("site_1"), "");
    expect(gateway.called("rois.system.get_profile").map(({ condition }) => condition)).toEqual([
      "component_ref LIKE 'hand/%'",
      "component_ref = 'hand/move'",
      "component_ref LIKE 'gateway/%'",
      "component_ref LIKE 'site\\_1/%'",
    ]);
    expect(loader.engine("site_1")).toBeNull();
  });

  it("asks again for the profile of an engine where that failed, and shows the newest alone", async () => {
    gateway.on("rois.system.get_profile", () => ({ return_code: "ERROR" }));
    await loader.wantEngine(entry("hand"), "");
    const profile = { identifier: { code: "gateway" } };
    gateway.on("rois.system.get_profile", () => ({ profile, component_profiles: {} }));
    const late = loader.wantEngine(entry("hand"), "");
    await loader.wantEngine(entry("gateway"), "");
    await late;
    expect([loader.engine("gateway"), loader.engine("hand"), loads]).toEqual([profile, null, 1]);
  });
});
