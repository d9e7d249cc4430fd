import { describe, expect, it } from "vitest";
import { jsonPieces } from "../../../app/inspector/controls.ts";

describe("jsonPieces", () => {
  it.each([
    [{ a: 'x: "1", true', b: [1, -2.5e3, true, null], "c\\": {} }],
    ["only 1 text"],
    [null],
    [[]],
    [undefined],
  ])("together are the text of %j", (value) => {
    const text = jsonPieces(value).map((piece) => piece.text);
    expect(text.join("")).toBe(JSON.stringify(value, null, 2) ?? "");
  });

  it("tells names, texts and the rest apart", () => {
    const pieces = jsonPieces({ name: "12", count: 3 }).filter(({ kind }) => kind !== "plain");
    expect(pieces).toEqual([
      { kind: "name", text: '"name"' },
      { kind: "string", text: '"12"' },
      { kind: "name", text: '"count"' },
      { kind: "literal", text: "3" },
    ]);
  });
});
