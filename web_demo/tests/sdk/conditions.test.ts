import { describe, expect, it } from "vitest";
import { and, escapeLike, like, onlyComponent, quote, where } from "../../sdk/rois/conditions.ts";

describe("conditions", () => {
  it("quote whatever characters there are", () => {
    expect(quote("o'clock")).toBe("'o''clock'");
    expect(onlyComponent("o'clock/x")).toBe("component_ref = 'o''clock/x'");
    expect(where({ component_ref: "' OR '1'='1" })).toBe("component_ref = ''' OR ''1''=''1'");
  });

  it("are joined, and nothing means everything", () => {
    expect(where({ component_ref: "a/b", stream_id: "s" })).toBe("component_ref = 'a/b' AND stream_id = 's'");
    expect(where({})).toBe("");
    expect(and("", where({ a: "1" }), "", like("b", "%"))).toBe("a = '1' AND b LIKE '%'");
    expect(and()).toBe("");
  });

  it("take the meaning from the characters of a pattern", () => {
    expect(like("component_ref", `${escapeLike("50%_\\o'clock")}/%`)).toBe(
      "component_ref LIKE '50\\%\\_\\\\o''clock/%'",
    );
  });
});
