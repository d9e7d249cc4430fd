/** Checks of what comes in, small enough to be shipped: each says in a sentence what is wrong. */

import { isObject } from "../jsonrpc/peer.ts";

/** Returns what is wrong with the value called `name`; null when it is right. */
export type Check = (value: unknown, name: string) => string | null;

export const text: Check = (value, name) => (typeof value === "string" ? null : `${name} must be text`);

export const integer: Check = (value, name) =>
  Number.isInteger(value) ? null : `${name} must be an integer`;

export const truth: Check = (value, name) =>
  typeof value === "boolean" ? null : `${name} must be true or false`;

/** Id of a JSON-RPC request. */
export const identity: Check = (value, name) =>
  typeof value === "string" || typeof value === "number" ? null : `${name} must be text or a number`;

/** The value may be absent. */
export const optional =
  (check: Check): Check =>
  (value, name) =>
    value === undefined ? null : check(value, name);

export const orNull =
  (check: Check): Check =>
  (value, name) =>
    value === null ? null : check(value, name);

export const oneOf =
  (names: readonly string[]): Check =>
  (value, name) =>
    names.some((each) => each === value) ? null : `${name} must be one of ${names.join(", ")}`;

export const list =
  (item: Check): Check =>
  (value, name) =>
    Array.isArray(value)
      ? first(value.entries(), ([index, each]) => item(each, `${name}.${index}`))
      : `${name} must be a list`;

export const map =
  (item: Check): Check =>
  (value, name) =>
    isObject(value)
      ? first(Object.entries(value), ([key, each]) => item(each, `${name}.${key}`))
      : `${name} must be an object`;

/** Unknown members are ignored. */
export const object =
  (members: { readonly [name: string]: Check }): Check =>
  (value, name) =>
    isObject(value)
      ? first(Object.entries(members), ([member, check]) => check(value[member], `${name}.${member}`))
      : `${name} must be an object`;

/** A structure that holds itself. */
export const itself =
  (check: () => Check): Check =>
  (value, name) =>
    check()(value, name);

function first<T>(items: Iterable<T>, check: (item: T) => string | null): string | null {
  for (const item of items) {
    const wrong = check(item);
    if (wrong !== null) return wrong;
  }
  return null;
}
