import { describe, expect, it } from "vitest";
import {
  fieldKind,
  itemType,
  listItems,
  listText,
  misfit,
  sameValue,
} from "../../../app/inspector/value_text.ts";

describe("fieldKind", () => {
  it.each([
    ["int", "integer"],
    ["Integer", "integer"],
    ["long", "integer"],
    ["short", "integer"],
    ["float", "number"],
    ["double", "number"],
    ["bool", "truth"],
    ["Boolean", "truth"],
    ["Component_Status", "status"],
    ["DateTime", "time"],
    ["String", "text"],
    ["Something_Else", "text"],
    ["", "text"],
    ["constructor", "text"],
    ["__proto__", "text"],
    ["int[]", "list"],
    ["Unknown[]", "list"],
    ["int[][]", "nested"],
  ])("of %s is %s", (code, kind) => {
    expect(fieldKind(code)).toBe(kind);
  });
});

describe("misfit", () => {
  it.each([
    ["int", "-42"],
    ["double", "1"],
    ["double", "-0.5e-3"],
    ["bool", "true"],
    ["boolean", "false"],
    ["Component_Status", "BUSY"],
    ["DateTime", "2026-06-01T12:00:00Z"],
    ["DateTime", "2026-06-01T12:00:00.123456+00:00"],
    ["string", ""],
    ["whatever", "anything"],
    ["string[]", '["a", ""]'],
    ["int[]", "[]"],
    ["int[]", "[1, -2]"],
    ["bool[]", "[true]"],
    ["double[]", "[1, 0.5]"],
    ["DateTime[]", '["2026-06-01T12:00:00Z"]'],
    ["int[][]", "[[1], []]"],
  ])("%s takes %s", (code, text) => {
    expect(misfit(code, text)).toBeNull();
  });

  it.each([
    ["int", "", "whole number"],
    ["int", "4.5", "whole number"],
    ["int", " 4", "whole number"],
    ["double", ".5", "number"],
    ["double", "1e999", "number"],
    ["double", "NaN", "number"],
    ["bool", "True", "true or false"],
    ["Component_Status", "ready", "READY"],
    ["DateTime", "yesterday", "ISO 8601"],
    ["DateTime", "2026-13-01T12:00:00Z", "ISO 8601"],
    ["int[]", "1, 2", "JSON array"],
    ["int[]", "{}", "JSON array"],
    ["int[]", '[1, "2"]', "Item 2: A whole number"],
    ["bool[]", '["true"]', "Item 1: true or false"],
    ["string[]", '["a", 1]', "Item 2: Text"],
    ["int[][]", "[1]", "Item 1: A JSON array"],
    ["int[][]", "[[1], [true]]", "Item 2: Item 1: A whole"],
    ["int[][]", "", "array of arrays"],
  ])("%s does not take %j, and says what it wants", (code, text, words) => {
    expect(misfit(code, text)).toContain(words);
  });
});

describe("lists", () => {
  it.each([
    ["string[]", ["a", '"', ""], '["a","\\"",""]'],
    ["int[]", ["1", "-2"], "[1,-2]"],
    ["bool[]", ["true"], "[true]"],
    ["DateTime[]", ["2026-06-01T12:00:00Z"], '["2026-06-01T12:00:00Z"]'],
    ["Unknown[]", ["1"], '["1"]'],
    ["int[]", ["1", "one"], '[1,"one"]'],
    ["string[]", [], "[]"],
  ])("%s of %j is written and read", (code, items, text) => {
    expect(listText(code, items)).toBe(text);
    expect(listItems(text)).toEqual(items);
  });

  it("keep every digit of a number", () => {
    const written = [" [12345678901234567890 ,1.0,\t-2e3]", '["]1,\\"", true, null]', "[[1.0], {}]"];
    expect(written.map(listItems)).toEqual([
      ["12345678901234567890", "1.0", "-2e3"],
      [']1,"', "true", "null"],
      ["[1]", "{}"],
    ]);
  });

  it("are not what is no JSON array", () => {
    expect([listItems(""), listItems("{}"), listItems("a")]).toEqual([null, null, null]);
    expect(itemType("int[][]")).toBe("int[]");
  });
});

describe("sameValue", () => {
  it.each([
    ["string[]", '["a", "b"]', '["a","b"]', true],
    ["string[]", "[]", "", false],
    ["string[]", "", "", true],
    ["int", "1", "01", false],
    ["int[]", "[12345678901234567890]", "[12345678901234567891]", false],
    ["int[]", '["1"]', "[1]", false],
    ["string", "[ ]", "[]", false],
  ])("of %s %j and %j is %s", (code, one, other, same) => {
    expect(sameValue(code, one, other)).toBe(same);
  });
});
