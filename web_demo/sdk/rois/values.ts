/** Values: text in every Result, Parameter and Argument, read by the `data_type_ref` of the profile. */

import { ValueError } from "./errors.ts";
import { ComponentStatus, StreamStatus } from "./generated/types.ts";

/** A value that was read: text, number, truth value, or a list of them. A DateTime stays text. */
export type Value = string | number | boolean | readonly Value[];

/** A value that can be written. */
export type Writable = Value | Date | readonly Writable[];

type Kind = "integer" | "number" | "truth" | "status" | "text";

const KINDS: { readonly [code: string]: Kind } = {
  int: "integer",
  integer: "integer",
  long: "integer",
  short: "integer",
  float: "number",
  double: "number",
  bool: "truth",
  boolean: "truth",
  component_status: "status",
};
const INTEGER = /^-?[0-9]{1,20}$/;
const NUMBER = /^-?[0-9]{1,40}(\.[0-9]{1,40})?([eE][+-]?[0-9]{1,4})?$/;
const MAX_DEPTH = 8;

const kindOf = (code: string): Kind => (Object.hasOwn(KINDS, code) ? KINDS[code] : undefined) ?? "text";
const isList = (code: string): boolean => code.endsWith("[]");
const itemOf = (code: string): string => code.slice(0, -2);

/**
 * Reads the text of a value.
 *
 * @param dataTypeRef the type's code, in any case: `int`, `double`, `boolean`, `Component_Status`, `T[]`; whatever else
 *   it names is text
 * @throws ValueError when it does not fit its type, or is an integer that a JavaScript number cannot hold
 */
export function decodeValue(dataTypeRef: string, text: string): Value {
  const code = dataTypeRef.toLowerCase();
  if (isList(code)) return decodeList(code, text);
  const value = decodeScalar(kindOf(code), text);
  if (value === undefined) throw new ValueError(`${shown(text)} is not of type ${dataTypeRef}`);
  return value;
}

/**
 * Writes a value as the text of its type.
 *
 * @throws ValueError when it does not fit its type: it is of another one, no finite number, too large, or no enumerator
 */
export function encodeValue(dataTypeRef: string, value: Writable): string {
  const code = dataTypeRef.toLowerCase();
  const plain = plainly(value);
  if (isList(code)) {
    checkItems(code, plain, 0);
    return JSON.stringify(plain);
  }
  if (!fits(kindOf(code), plain) || !isEnumerator(code, plain)) {
    throw new ValueError(`${shown(plain)} is not of type ${dataTypeRef}`);
  }
  return typeof plain === "string" ? plain : JSON.stringify(plain);
}

/** A Date becomes ISO 8601. */
function plainly(value: Writable): Value {
  if (Array.isArray(value)) return value.map(plainly);
  if (!(value instanceof Date)) return value as Value;
  if (Number.isNaN(value.getTime())) throw new ValueError("a DateTime cannot be an invalid Date");
  return value.toISOString();
}

/** Of a Stream_Status the wire takes any text, but we send what there is. */
const isEnumerator = (code: string, plain: Value): boolean =>
  code !== "stream_status" || StreamStatus.some((name) => name === plain);

const shown = (value: unknown): string => JSON.stringify(String(value).slice(0, 80));

function decodeScalar(kind: Kind, text: string): Value | undefined {
  switch (kind) {
    case "integer":
      return INTEGER.test(text) ? exact(Number(text)) : undefined;
    case "number":
      return NUMBER.test(text) ? finite(Number(text)) : undefined;
    case "truth":
      return text === "true" ? true : text === "false" ? false : undefined;
    case "status":
      return ComponentStatus.find((name) => name === text);
    case "text":
      return text;
  }
}

function decodeList(code: string, text: string): Value {
  let parsed: unknown;
  try {
    parsed = JSON.parse(text);
  } catch {
    throw new ValueError(`${shown(text)} is not a JSON array`);
  }
  checkItems(code, parsed, 0);
  return parsed as Value;
}

function checkItems(code: string, parsed: unknown, depth: number): void {
  if (!Array.isArray(parsed) || depth >= MAX_DEPTH) {
    throw new ValueError(`a value of type ${code} must be a JSON array, nested at most ${MAX_DEPTH} deep`);
  }
  const itemCode = itemOf(code);
  for (const item of parsed) {
    if (isList(itemCode)) checkItems(itemCode, item, depth + 1);
    else if (!fits(kindOf(itemCode), item)) {
      throw new ValueError(`an item of the array is not of type ${itemCode}`);
    }
  }
}

function fits(kind: Kind, item: unknown): boolean {
  switch (kind) {
    case "integer":
      return Number.isSafeInteger(item);
    case "number":
      return Number.isFinite(item);
    case "truth":
      return typeof item === "boolean";
    default:
      return typeof item === "string" && decodeScalar(kind, item) !== undefined;
  }
}

/** Better refused than changed without a word; and -0 is no integer of its own. */
const exact = (value: number): number | undefined => (Number.isSafeInteger(value) ? value || 0 : undefined);
const finite = (value: number): number | undefined => (Number.isFinite(value) ? value : undefined);
