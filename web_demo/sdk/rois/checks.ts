/** Checks of results and notifications: required members are present, and types are right. */

import { object, oneOf } from "./check.ts";
import type { Check } from "./check.ts";
import { NOTIFICATIONS, RESULTS } from "./generated/checks.ts";
import { ReturnCode } from "./generated/types.ts";

/** Result of a method of another extension: only its return code is known. */
const someResult = object({ return_code: oneOf(ReturnCode) });

/** Returns what is wrong with the result of a method; null when nothing is. */
export const wrongInResult = (method: string, value: unknown): string | null =>
  (checkOf(RESULTS, method) ?? someResult)(value, "result");

/** Returns what is wrong with the params of a notification; null when nothing is. */
export const wrongInNotification = (method: string, value: unknown): string | null =>
  checkOf(NOTIFICATIONS, method)?.(value, "params") ?? null;

const checkOf = (checks: { readonly [method: string]: Check }, method: string): Check | undefined =>
  Object.hasOwn(checks, method) ? checks[method] : undefined;
