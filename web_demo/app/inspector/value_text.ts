/** Values as text: which field a type wants, whether a text fits it, and lists as their items. Pure. */

import { ComponentStatus } from "../../sdk/index.ts";

export type FieldKind = "integer" | "number" | "truth" | "status" | "time" | "text" | "list" | "nested";

const KINDS: ReadonlyMap<string, FieldKind> = new Map<string, FieldKind>(
  Object.entries({
    int: "integer",
    integer: "integer",
    long: "integer",
    short: "integer",
    float: "number",
    double: "number",
    bool: "truth",
    boolean: "truth",
    component_status: "status",
    datetime: "time",
  }),
);

/** Returns what a type is edited with. A type that is not known is text. */
export function fieldKind(code: string): FieldKind {
  if (code.endsWith("[][]")) return "nested";
  if (code.endsWith("[]")) return "list";
  return KINDS.get(code.toLowerCase()) ?? "text";
}

/** Returns the type of a list's items. */
export function itemType(code: string): string {
  return code.slice(0, -2);
}

const EXPECTED: Readonly<Record<Exclude<FieldKind, "text">, string>> = {
  integer: "A whole number is expected, such as 42.",
  number: "A number is expected, such as 0.5 or 1e-3.",
  truth: "true or false is expected.",
  status: `One of ${ComponentStatus.join(", ")} is expected.`,
  time: "A date and time of ISO 8601 is expected, such as 2026-06-01T12:00:00Z.",
  list: "A JSON array is expected.",
  nested: 'A JSON array of arrays is expected, such as [["a"], ["b"]].',
};

const INTEGER = /^-?\d{1,20}$/;
const NUMBER = /^-?\d{1,40}(\.\d{1,40})?(e[+-]?\d{1,4})?$/i;
const TIME = /^\d{4}-\d\d-\d\dT\d\d:\d\d(:\d\d(\.\d+)?)?(Z|[+-]\d\d:?\d\d)?$/;

/** Returns what is wrong with a text of a type, as a sentence; null when it fits. */
export function misfit(code: string, text: string): string | null {
  const kind = fieldKind(code);
  if (kind === "list" || kind === "nested") return listMisfit(code, parsed(text));
  return kind === "text" || fits(kind, text) ? null : EXPECTED[kind];
}

function fits(kind: Exclude<FieldKind, "text" | "list" | "nested">, text: string): boolean {
  switch (kind) {
    case "integer":
      return INTEGER.test(text);
    case "number":
      return NUMBER.test(text) && Number.isFinite(Number(text));
    case "truth":
      return text === "true" || text === "false";
    case "status":
      return ComponentStatus.some((each) => each === text);
    case "time":
      return TIME.test(text) && !Number.isNaN(Date.parse(text));
  }
}

function listMisfit(code: string, items: unknown): string | null {
  if (!Array.isArray(items)) return fieldKind(code) === "nested" ? EXPECTED.nested : EXPECTED.list;
  const type = itemType(code);
  for (const [index, item] of items.entries()) {
    const wrong = type.endsWith("[]") ? listMisfit(type, item) : itemMisfit(type, item);
    if (wrong !== null) return `Item ${index + 1}: ${wrong}`;
  }
  return null;
}

/** In a list numbers and truth values stand as such, and all else as text. */
function itemMisfit(type: string, item: unknown): string | null {
  const kind = fieldKind(type);
  const plain = kind === "integer" || kind === "number" ? "number" : kind === "truth" ? "boolean" : "string";
  if (typeof item === plain) return misfit(type, String(item));
  return kind === "text" ? "Text is expected." : EXPECTED[kind];
}

/** Returns the items of a list, each as a text of its own; null when the text is no JSON array. */
export function listItems(text: string): string[] | null {
  const items: unknown = parsed(text);
  if (!Array.isArray(items)) return null;
  // Numbers as they are written: JavaScript's have fewer digits.
  const written = items.some(isComposed) ? [] : (text.match(ITEM) ?? []);
  return items.map((item: unknown, index) =>
    typeof item === "string" ? item : (written[index] ?? JSON.stringify(item)),
  );
}

/** One item of a list that has no lists or objects in it. */
const ITEM = /"(?:[^"\\]|\\.)*"|[^\s,[\]]+/g;

const isComposed = (item: unknown): boolean => typeof item === "object" && item !== null;

/** Returns the text of a list of these items; what does not fit its type stands in it as text. */
export function listText(code: string, items: readonly string[]): string {
  const type = itemType(code);
  const quoted = ["text", "time", "status"].includes(fieldKind(type));
  const written = items.map((item) => (quoted || misfit(type, item) !== null ? JSON.stringify(item) : item));
  return `[${written.join(",")}]`;
}

/** Whether two texts of a type are one value: lists may be written with or without spaces. */
export function sameValue(code: string, one: string, other: string): boolean {
  if (one === other || !code.endsWith("[]")) return one === other;
  const [first, second] = [parsed(one), parsed(other)];
  if (first === undefined || JSON.stringify(first) !== JSON.stringify(second)) return false;
  return JSON.stringify(listItems(one)) === JSON.stringify(listItems(other));
}

function parsed(text: string): unknown {
  try {
    return JSON.parse(text);
  } catch {
    return undefined;
  }
}
