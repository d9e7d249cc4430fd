import { describe, expect, it } from "vitest";
import {
  componentsOf,
  engineTree,
  enginesOf,
  statusQuery,
  withAway,
  visibleRows,
} from "../../../app/inspector/profile_tree.ts";
import type { HRIComponentProfile, Profile } from "../../../sdk/index.ts";

const named = (name: string, code = "string") => ({ name, data_type_ref: { code } });
const component = (type: string, more: Partial<HRIComponentProfile> = {}): HRIComponentProfile => ({
  identifier: { code: `urn:x-test:${type}` },
  name: type.toLowerCase(),
  ...more,
});

const PROFILE: Profile = {
  profile: {
    identifier: { code: "gateway" },
    component_ids: ["gateway/clock", "robot/arm", "robot/ear", "hand/finger"],
    sub_profiles: [
      {
        identifier: { code: "robot" },
        component_ids: ["robot/arm", "robot/ear", "hand/finger"],
        sub_profiles: [{ identifier: { code: "hand" }, component_ids: ["hand/finger"] }],
      },
      { identifier: { code: "empty" } },
    ],
  },
  component_profiles: {
    "gateway/clock": component("Clock"),
    "robot/arm": component("Arm", {
      function: "actuation",
      command_profiles: [{ name: "lift", arguments: [named("height", "int")], results: [named("weight")] }],
      parameter_profiles: [named("speed")],
    }),
    "robot/ear": component("Ear", { event_profiles: [{ name: "heard", results: [named("words")] }] }),
    "hand/finger": component("Finger"),
    "stray/a": component("Stray"),
    "stray/b": component("Stray"),
  },
};

const tree = engineTree(PROFILE);
const all = (): boolean => true;
const shown = (isExpanded: (id: string) => boolean, search = ""): string[] =>
  visibleRows(tree, isExpanded, search).map(({ id, level }) => `${level} ${id}`);

describe("engineTree", () => {
  it("has every engine and every component once, also those that no engine lists", () => {
    expect(enginesOf(tree).map(({ id }) => id)).toEqual(["gateway", "robot", "hand", "empty", "stray"]);
    expect(
      componentsOf(tree)
        .map(({ ref }) => ref)
        .sort(),
    ).toEqual(Object.keys(PROFILE.component_profiles).sort());
  });

  it("survives an engine without a profile, and a component without one", () => {
    expect(engineTree({ profile: null, component_profiles: {} })).toEqual([]);
    const [engine] = engineTree({
      profile: { identifier: { code: "e" }, component_ids: ["e/new/part"] },
      component_profiles: {},
    });
    expect(engine?.components[0]).toMatchObject({ ref: "e/new/part", name: "new/part" });
  });
});

describe("visibleRows", () => {
  it("shows what is expanded, with how much there is in each engine", () => {
    expect(shown(all)).toEqual([
      "1 gateway",
      "2 gateway/clock",
      "2 robot",
      "3 robot/arm",
      "3 robot/ear",
      "3 hand",
      "4 hand/finger",
      "2 empty",
      "1 stray",
      "2 stray/a",
      "2 stray/b",
    ]);
    expect(shown((id) => id === "gateway")).toEqual([
      "1 gateway",
      "2 gateway/clock",
      "2 robot",
      "2 empty",
      "1 stray",
    ]);
    expect(visibleRows(tree, all).map(({ count }) => count)).toEqual([4, 0, 3, 0, 0, 1, 0, 0, 2, 0, 0]);
  });

  it.each<[string, string[]]>([
    ["finger", ["1 gateway", "2 robot", "3 hand", "4 hand/finger"]],
    ["ROBOT ear", ["1 gateway", "2 robot", "3 robot/ear"]],
    ["hand", ["1 gateway", "2 robot", "3 hand", "4 hand/finger"]],
    ["actuation", ["1 gateway", "2 robot", "3 robot/arm"]],
    ["empty", ["1 gateway", "2 empty"]],
    ["nowhere", []],
  ])("searches for %j, whatever is expanded", (search, rows) => {
    expect(shown(() => false, search)).toEqual(rows);
  });

  it.each([
    ["height", "height"],
    ["heard", "heard"],
    ["words", "words"],
    ["speed", "speed"],
    ["robot/arm", ""],
  ])("tells by what %s was found", (search, found) => {
    expect(visibleRows(tree, all, search).at(-1)?.found).toBe(found);
  });
});

describe("statusQuery", () => {
  it("is the plainest query that answers with a status, whatever its name", () => {
    const status = named("a", "Component_Status");
    const query_profiles = [
      { name: "long", results: [named("b"), status] },
      { name: "short", results: [status] },
      { name: "other", results: [named("c")] },
    ];
    expect(statusQuery(component("X", { query_profiles }))).toBe("short");
    expect(statusQuery(component("X"))).toBeNull();
  });
});

describe("withAway", () => {
  const gone = (ref: string) => ({ ref, name: ref, profile: component("Gone"), isLoaded: true, terms: [] });
  const ids = (engines: readonly (typeof tree)[number][]): string[] =>
    visibleRows(engines, all).map(({ id }) => id);

  it("adds what was chosen and has left, at its engine or with it", () => {
    expect(ids(withAway(tree, "hand/thumb", gone("hand/thumb")))).toContain("hand/thumb");
    expect(ids(withAway(tree, "lost/thing", gone("lost/thing"))).slice(-2)).toEqual(["lost", "lost/thing"]);
    expect(ids(withAway(tree, "lost", null)).at(-1)).toBe("lost");
  });

  it.each(["", "robot", "robot/arm", "never/seen"])("adds nothing for %j", (id) => {
    expect(withAway(tree, id, null)).toBe(tree);
  });
});
