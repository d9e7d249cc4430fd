/** The rules of `openrois/types/values.py`, with the numbers of JavaScript. */

import { describe, expect, it } from "vitest";
import { ValueError } from "../../sdk/rois/errors.ts";
import { decode, encode, resultValue } from "../../sdk/rois/payload.ts";
import type { Types } from "../../sdk/rois/payload.ts";
import { decodeValue, encodeValue } from "../../sdk/rois/values.ts";
import type { Value, Writable } from "../../sdk/rois/values.ts";

describe("a value is read", () => {
  it.each<[string, string, Value]>([
    ["int", "0", 0],
    ["Integer", "-17", -17],
    ["long", "9007199254740991", 9007199254740991],
    ["short", "007", 7],
    ["double", "1", 1],
    ["FLOAT", "-1.5e-3", -0.0015],
    ["double", "1e308", 1e308],
    ["bool", "true", true],
    ["Boolean", "false", false],
    ["Component_Status", "BUSY", "BUSY"],
    ["string", "", ""],
    ["Stream_Status", "anything", "anything"],
    ["DateTime", "yesterday", "yesterday"],
    ["constructor", "of no type", "of no type"],
    ["string[]", '["a", "b"]', ["a", "b"]],
    ["RoISIdentifier[]", "[]", []],
    ["int[]", "[1, -2]", [1, -2]],
    ["double[]", "[1, 2.5, -1e-3]", [1, 2.5, -0.001]],
    ["bool[]", "[true, false]", [true, false]],
    ["Component_Status[]", '["READY"]', ["READY"]],
    ["int[][]", "[[1],[2,3],[]]", [[1], [2, 3], []]],
    ["string[][][][][][][][]", '[[[[[[[["a"]]]]]]]]', [[[[[[[["a"]]]]]]]]],
  ])("%s %s", (type, text, value) => {
    expect(decodeValue(type, text)).toEqual(value);
  });

  it.each([
    ["int", ""],
    ["int", "+5"],
    ["int", "1.0"],
    ["int", " 1"],
    ["int", "1\n"],
    ["int", "٣"],
    ["int", "9".repeat(21)],
    ["int", "9007199254740992"],
    ["int[]", "[9007199254740993]"],
    ["double", "nan"],
    ["double", "1."],
    ["double", ".5"],
    ["double", "1e"],
    ["double", "1e309"],
    ["bool", "True"],
    ["bool", "1"],
    ["Component_Status", "ready"],
    ["Component_Status", "1"],
    ["string[]", "a"],
    ["string[]", '"a"'],
    ["string[]", '{"a":1}'],
    ["string[]", "[1]"],
    ["string[]", '["a",]'],
    ["string[]", "[".repeat(20_000)],
    ["int[]", '["1"]'],
    ["int[]", "[1.5]"],
    ["int[]", "[true]"],
    ["double[]", "[NaN]"],
    ["double[]", "[1e999]"],
    ["double[]", "[true]"],
    ["bool[]", "[1]"],
    ["Component_Status[]", '["ready"]'],
    ["int[][]", "[1]"],
    ["int[][]", "[[1],2]"],
    [`string${"[]".repeat(9)}`, "[".repeat(9) + "]".repeat(9)],
  ])("but not %s %s", (type, text) => {
    expect(() => decodeValue(type, text)).toThrow(ValueError);
  });
});

describe("a value is written", () => {
  it.each<[string, Writable, string]>([
    ["int", 5, "5"],
    ["INTEGER", -9007199254740991, "-9007199254740991"],
    ["double", 0.1, "0.1"],
    ["float", 1e-7, "1e-7"],
    ["double", 1.7976931348623157e308, "1.7976931348623157e+308"],
    ["bool", true, "true"],
    ["Boolean", false, "false"],
    ["string", 'say "hi"', 'say "hi"'],
    ["DateTime", new Date("2026-06-01T12:00:00Z"), "2026-06-01T12:00:00.000Z"],
    ["DateTime", "whatever", "whatever"],
    ["Component_Status", "BUSY", "BUSY"],
    ["Stream_Status", "STREAMING_RUNNING", "STREAMING_RUNNING"],
    ["RoISIdentifier[]", ["a", "お辞儀"], '["a","お辞儀"]'],
    ["int[]", [], "[]"],
    ["int[][]", [[1], [2, 3]], "[[1],[2,3]]"],
    ["Component_Status[]", ["ERROR"], '["ERROR"]'],
    ["DateTime[]", [new Date(0)], '["1970-01-01T00:00:00.000Z"]'],
  ])("%s %s", (type, value, text) => {
    expect(encodeValue(type, value)).toBe(text);
    decodeValue(type, text);
  });

  it.each<[string, unknown]>([
    ["double", Number.NaN],
    ["double", Number.POSITIVE_INFINITY],
    ["double[]", [1, Number.NEGATIVE_INFINITY]],
    ["int", 2 ** 53],
    ["int", 1.5],
    ["int", true],
    ["int", "5"],
    ["double", "0.5"],
    ["bool", 1],
    ["bool", "true"],
    ["string", 5],
    ["string", null],
    ["string", ["a"]],
    ["DateTime", 0],
    ["DateTime", new Date("never")],
    ["Component_Status", "ready"],
    ["Component_Status[]", ["READY", "OK"]],
    ["Stream_Status", "RUNNING"],
    ["string[]", "a"],
    ["string[]", [1]],
    ["int[][]", [1]],
  ])("but not %s %s", (type, value) => {
    expect(() => encodeValue(type, value as Writable)).toThrow(ValueError);
  });
});

interface Meeting {
  readonly when: Date;
  readonly also?: readonly Date[];
  readonly persons: number;
}
const MEETING: Types<Meeting> = { when: "DateTime", also: "DateTime[]?", persons: "int" };

describe("a payload", () => {
  const result = (name: string, value: string, data_type_ref = "string") => ({ name, data_type_ref, value });

  it("is read by its types, whatever type the other side writes, and what it does not know passed over", () => {
    const results = [
      result("persons", "2", "long"),
      result("when", "2026-06-01T12:00:00Z"),
      result("x", "y"),
    ];
    expect(decode(MEETING, results)).toEqual({ when: new Date("2026-06-01T12:00:00Z"), persons: 2 });
    expect(decode(MEETING, [], true)).toEqual({});
    expect(resultValue(results, "x")).toBe("y");
  });

  it("comes back as it was written", () => {
    const meeting: Meeting = { when: new Date(1), also: [new Date(2)], persons: 0 };
    expect(encode(MEETING, meeting).map(({ data_type_ref }) => data_type_ref)).toEqual([
      "DateTime",
      "DateTime[]",
      "int",
    ]);
    expect(decode(MEETING, encode(MEETING, meeting))).toEqual(meeting);
  });

  it.each([
    ["2026-06-01T12:00:00.123456+00:00", "2026-06-01T12:00:00.123Z"],
    ["2026-06-01 21:00:00,5+0900", "2026-06-01T12:00:00.500Z"],
    ["2026-06-01T21:00+09", "2026-06-01T12:00:00.000Z"],
    ["2026-06-01T12:00:00Z", "2026-06-01T12:00:00.000Z"],
  ])("has moments in the forms of ISO 8601: %s", (text, expected) => {
    expect(decode({ t: "DateTime" }, [result("t", text)])).toEqual({ t: new Date(expected) });
  });

  it.each(["", "noon", "2026-06-01", "June 1, 2026 12:00", "2026-13-01T12:00:00Z", "1780315200"])(
    "but %j is none",
    (text) => {
      expect(() => decode({ t: "DateTime" }, [result("t", text)])).toThrow(/^t: .* is not of type DateTime/);
    },
  );

  it("has the statuses of streams that there are", () => {
    const types = { status: "Stream_Status" };
    expect(decode(types, [result("status", "STREAMING_RUNNING")])).toEqual({ status: "STREAMING_RUNNING" });
    expect(() => decode(types, [result("status", "RUNNING")])).toThrow('status: "RUNNING" is not of type');
  });

  it("says which value is wrong, missing or unknown", () => {
    expect(() => decode(MEETING, [result("persons", "two")])).toThrow("when is missing");
    expect(() => decode(MEETING, [result("persons", "two")], true)).toThrow(
      'persons: "two" is not of type int',
    );
    expect(() => encode(MEETING, { persons: 0.5 })).toThrow('persons: "0.5" is not of type int');
    expect(() => encode(MEETING, { colour: "red" } as never)).toThrow("there is no value called colour");
  });
});
