/**
 * What comes in is what its method gives, as far as this client relies on it: names, lists and texts are where they
 * belong. Members that nobody knows are passed over, and there is no schema library: it would be larger than the SDK.
 */

import { isObject } from "../jsonrpc/peer.ts";
import type { Methods, Notifications } from "./generated/methods.ts";
import {
  CompletedStatus,
  ComponentFunction,
  ErrorType,
  ReturnCode,
  StreamStatus,
} from "./generated/types.ts";

/** Returns what is wrong with the value called `name`; null when it is right. */
type Check = (value: unknown, name: string) => string | null;

const text: Check = (value, name) => (typeof value === "string" ? null : `${name} must be text`);
const number: Check = (value, name) => (Number.isFinite(value) ? null : `${name} must be a number`);
const optional =
  (check: Check): Check =>
  (value, name) =>
    value === undefined ? null : check(value, name);
const nullable =
  (check: Check): Check =>
  (value, name) =>
    value === undefined || value === null ? null : check(value, name);
const oneOf =
  (names: readonly string[]): Check =>
  (value, name) =>
    names.includes(value as string) ? null : `${name} must be one of ${names.join(", ")}`;
const list =
  (item: Check): Check =>
  (value, name) =>
    Array.isArray(value)
      ? first(value, (each, index) => item(each, `${name}.${index}`))
      : `${name} must be a list`;
const map =
  (item: Check): Check =>
  (value, name) =>
    isObject(value)
      ? first(Object.entries(value), ([key, each]) => item(each, `${name}.${key}`))
      : `${name} must be an object`;
const object =
  (members: { readonly [name: string]: Check }): Check =>
  (value, name) =>
    isObject(value)
      ? first(Object.entries(members), ([member, check]) => check(value[member], `${name}.${member}`))
      : `${name} must be an object`;

function first<T>(items: readonly T[], check: (item: T, index: number) => string | null): string | null {
  for (const [index, item] of items.entries()) {
    const wrong = check(item, index);
    if (wrong !== null) return wrong;
  }
  return null;
}

const anything: Check = () => null;
const texts = optional(list(text));
const values = optional(list(object({ name: text, data_type_ref: text, value: text })));
const identifier = object({ code: text, authority: optional(text) });
const parameters = optional(
  list(object({ name: text, data_type_ref: identifier, default_value: optional(text) })),
);
const messages = optional(
  list(object({ name: text, results: parameters, arguments: parameters, timeout: nullable(number) })),
);
const component = object({
  identifier,
  name: text,
  function: nullable(oneOf(ComponentFunction)),
  sub_component_profiles: texts,
  command_profiles: messages,
  query_profiles: messages,
  event_profiles: messages,
  parameter_profiles: parameters,
});
const engine: Check = object({
  identifier,
  sub_profiles: optional((value, name) => list(engine)(value, name)),
  component_ids: texts,
  parameter_profiles: parameters,
});

const nothing = anything;
const results = object({ results: values });
const RESULTS: { readonly [Method in keyof Methods]: Check } = {
  "rois.system.connect": nothing,
  "rois.system.disconnect": nothing,
  "rois.system.get_profile": object({
    profile: nullable(engine),
    component_profiles: optional(map(component)),
  }),
  "rois.system.get_error_detail": results,
  "rois.command.search": object({ component_ref_list: texts }),
  "rois.command.bind": nothing,
  "rois.command.bind_any": object({ component_ref: text }),
  "rois.command.release": nothing,
  "rois.command.get_parameter": object({ parameters: values }),
  "rois.command.set_parameter": object({ command_id: text }),
  "rois.command.execute": nothing,
  "rois.command.get_command_result": results,
  "rois.query.query": results,
  "rois.event.subscribe": object({ subscribe_id: text }),
  "rois.event.unsubscribe": nothing,
  "rois.event.get_event_detail": results,
  "openrois.hello": object({ version: optional(text), extensions: texts, client_id: optional(text) }),
  "rois.stream.connect_stream": object({ stream_id: text }),
  "rois.stream.disconnect_stream": nothing,
  "rois.stream.suspend_stream": nothing,
  "rois.stream.resume_stream": nothing,
  "rois.stream.query_stream_status": object({ status: oneOf(StreamStatus) }),
  "signaling.answer": nothing,
  "signaling.candidate": nothing,
  "signaling.restart": nothing,
  "signaling.ice_servers": object({
    ice_servers: optional(
      list(object({ urls: list(text), username: nullable(text), credential: nullable(text) })),
    ),
    ttl: optional(number),
  }),
};

const NOTIFICATIONS: { readonly [Method in keyof Notifications]: Check } = {
  "rois.system.notify_error": object({ error_id: text, error_type: oneOf(ErrorType) }),
  "rois.system.profile_changed": nothing,
  "rois.command.completed": object({ command_id: text, status: oneOf(CompletedStatus) }),
  "rois.event.notify_event": object({
    event_id: text,
    event_type: text,
    subscribe_id: text,
    expire: optional(text),
    results: values,
  }),
  "rois.stream.notify_stream_status": object({
    stream_id: text,
    component_ref: text,
    status: oneOf(StreamStatus),
    timestamp: text,
  }),
  "signaling.offer": object({
    peer_id: text,
    generation: number,
    sdp: text,
    streams: list(object({ mid: text, stream_id: text, component_ref: text })),
    replaces: nullable(text),
  }),
  "signaling.candidate": object({
    peer_id: text,
    generation: number,
    candidate: nullable(text),
    sdp_mid: nullable(text),
    sdp_m_line_index: nullable(number),
  }),
  "signaling.bye": object({ peer_id: text, reason: text }),
};

const returnCode = object({ return_code: oneOf(ReturnCode) });

/** Returns what is wrong with the result of a method; null when nothing is. */
export function wrongInResult(method: string, result: unknown): string | null {
  const wrong = returnCode(result, "result");
  // A refusal is nothing but its return code.
  if (wrong !== null || (isObject(result) && result["return_code"] !== "OK")) return wrong;
  return checkOf(RESULTS, method)(result, "result");
}

/** Returns what is wrong with the params of a notification; null when nothing is. */
export function wrongInNotification(method: string, params: unknown): string | null {
  return checkOf(NOTIFICATIONS, method)(params, "params");
}

const checkOf = (checks: { readonly [method: string]: Check }, method: string): Check =>
  (Object.hasOwn(checks, method) ? checks[method] : undefined) ?? anything;
