import { describe, expect, it } from "vitest";
import { componentType, componentsByEngine, engineOf, onlyComponent } from "../../sdk/rois/discovery.ts";
import { listValue, resultValue } from "../../sdk/rois/types.ts";

describe("values", () => {
  it.each([
    ['["a","b"]', ["a", "b"]],
    ['["a",1,null]', ["a"]],
    ['"a"', []],
    ["[", []],
    [undefined, []],
  ])("the list in %o", (text, expected) => {
    expect(listValue(text)).toEqual(expected);
  });

  it("are found by name", () => {
    const results = [{ name: "status", data_type_ref: "Component_Status", value: "READY" }];
    expect(resultValue(results, "status")).toBe("READY");
    expect(resultValue(results, "other")).toBeUndefined();
  });
});

describe("discovery", () => {
  it("reads the type of a component, whichever form its code has", () => {
    const type = (code: string): string => componentType({ identifier: { code }, name: "x" });
    expect(type("urn:x-rois:def:component:OMG::Reaction")).toBe("Reaction");
    expect(type("Reaction")).toBe("Reaction");
    expect(type("")).toBe("");
  });

  it("groups by engine", () => {
    const profile = { identifier: { code: "X::T" }, name: "x" };
    const found = componentsByEngine({
      profile: null,
      component_profiles: { "a/1": profile, "a/2": profile },
    });
    expect([...found].map(([engine, types]) => [engine, [...types]])).toEqual([["a", [["T", "a/1"]]]]);
    expect(engineOf("a/1")).toBe("a");
  });

  it("names one component, whatever characters it has", () => {
    expect(onlyComponent("o'clock/x")).toBe("component_ref = 'o''clock/x'");
  });
});
