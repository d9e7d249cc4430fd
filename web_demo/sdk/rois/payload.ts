/** Payload of a message: an object in the program, named texts on the wire. */

import { ValueError } from "./errors.ts";
import { StreamStatus } from "./generated/types.ts";
import type { Result } from "./generated/types.ts";
import { decodeValue, encodeValue } from "./values.ts";
import type { Writable } from "./values.ts";

/**
 * The `data_type_ref` of each value of a payload, such as `{ target: "string", is_final_target: "bool" }`. A `?` behind
 * it says that the value may be absent.
 */
export type Types<Payload> = { readonly [Name in keyof Payload]-?: string };

/**
 * Reads results or parameters; what the type does not name is passed over.
 *
 * @param partial whether every value may be absent
 * @throws ValueError when a value is missing or does not fit its type
 */
export function decode<Payload>(types: Types<Payload>, results: readonly Result[], partial = false): Payload {
  const payload: Record<string, unknown> = {};
  for (const [name, type] of entries(types)) {
    const text = resultValue(results, name);
    if (text !== undefined) payload[name] = named(name, () => read(code(type), text));
    else if (!partial && !type.endsWith("?")) throw new ValueError(`${name} is missing`);
  }
  return payload as Payload;
}

/**
 * Writes arguments or parameters. A value that is undefined is left out.
 *
 * @throws ValueError when a value does not fit its type, or has a name that the type does not know
 */
export function encode<Payload>(types: Types<Payload>, payload: Partial<Payload>): Result[] {
  const known = new Map(entries(types));
  return Object.entries<unknown>(payload)
    .filter(([, value]) => value !== undefined)
    .map(([name, value]) => {
      const type = known.get(name);
      if (type === undefined)
        throw new ValueError(`there is no value called ${name}: use one of ${[...known.keys()].join(", ")}`);
      return {
        name,
        data_type_ref: code(type),
        value: named(name, () => encodeValue(code(type), value as Writable)),
      };
    });
}

/** Returns the text of the result called `name`, or undefined when it is not there. */
export function resultValue(results: readonly Result[], name: string): string | undefined {
  return results.find((result) => result.name === name)?.value;
}

const entries = (types: object): [string, string][] => Object.entries(types);
const code = (type: string): string => (type.endsWith("?") ? type.slice(0, -1) : type);

function read(dataTypeRef: string, text: string): unknown {
  const value = decodeValue(dataTypeRef, text);
  if (dataTypeRef.toLowerCase() === "stream_status" && !StreamStatus.some((name) => name === value)) {
    throw new ValueError(`${JSON.stringify(value)} is not of type ${dataTypeRef}`);
  }
  return dataTypeRef.toLowerCase().startsWith("datetime") ? dated(value) : value;
}

function dated(value: unknown): unknown {
  if (Array.isArray(value)) return value.map(dated);
  const date = new Date(MOMENT.test(String(value)) ? standardForm(String(value)) : "");
  if (Number.isNaN(date.getTime())) throw new ValueError(`${JSON.stringify(value)} is not of type DateTime`);
  return date;
}

/** A date and a time of ISO 8601. What else `Date` reads differs from one platform to the next. */
const MOMENT = /^\d{4}-\d\d-\d\d[T ]\d\d:\d\d(:\d\d([.,]\d+)?)?(Z|[+-]\d\d(:?\d\d)?)?$/;

/** The one form that every platform has to read: milliseconds, and a colon in the offset. */
const standardForm = (text: string): string =>
  text
    .replace(" ", "T")
    .replace(/[.,](\d{1,3})\d*/, ".$1")
    .replace(/([+-]\d\d):?(\d\d)?$/, (_, hours: string, minutes = "00") => `${hours}:${minutes}`);

/** The name of the value stands before what is wrong with it. */
function named<T>(name: string, step: () => T): T {
  try {
    return step();
  } catch (error) {
    throw error instanceof ValueError ? new ValueError(`${name}: ${error.message}`) : error;
  }
}
