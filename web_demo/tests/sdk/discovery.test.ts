import { describe, expect, it } from "vitest";
import { componentType, componentUrn, componentsByEngine, engineOf } from "../../sdk/rois/discovery.ts";

describe("discovery", () => {
  it("reads the type of a component, whichever form its code has", () => {
    const type = (code: string): string => componentType({ identifier: { code }, name: "x" });
    expect(type("urn:x-rois:def:component:OMG::Reaction")).toBe("Reaction");
    expect(type("Reaction")).toBe("Reaction");
    expect(type("")).toBe("");
  });

  it("forms the URN of authority and code", () => {
    const urn = (code: string, authority?: string): string =>
      componentUrn({ identifier: authority === undefined ? { code } : { code, authority }, name: "x" });
    expect(urn("Reaction", "OMG")).toBe("urn:x-rois:def:component:OMG::Reaction");
    expect(urn("urn:x-rois:def:component:OMG::Reaction", "OMG")).toBe(
      "urn:x-rois:def:component:OMG::Reaction",
    );
    expect(urn("Reaction")).toBe("urn:x-rois:def:component:::Reaction");
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
});
