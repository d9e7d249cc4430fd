/** The data of RoIS 2.0 in its JSON form: enumerations as names, fields named as in the standard's XML schema. */

import type { Json, JsonObject } from "../jsonrpc/peer.ts";

/** How an operation ended (ReturnCode_t). */
export type ReturnCode = "OK" | "ERROR" | "BAD_PARAMETER" | "UNSUPPORTED" | "OUT_OF_RESOURCES" | "TIMEOUT";

/** How a command ended (Completed_Status). */
export type CompletedStatus = "OK" | "ERROR" | "ABORT" | "OUT_OF_RESOURCES" | "TIMEOUT";

/** What a component is able to do now (Component_Status). */
export type ComponentStatus = "UNINITIALIZED" | "READY" | "BUSY" | "WARNING" | "ERROR";

/** What a stream does (Stream_Status). RESUMED is announced as an event and is never a state. */
export type StreamStatus =
  | "STREAMING_NOT_CONNECTED"
  | "STREAMING_NOT_RUNNING"
  | "STREAMING_RUNNING"
  | "STREAMING_SUSPENDED"
  | "STREAMING_RESUMED";

/** A named value with its type; `value` is always text. */
export type NamedValue = { name: string; data_type_ref: string; value: string };

/** One command of a sequence. `delay_time` is in milliseconds; a missing `command_id` is minted on sending. */
export type CommandUnit = {
  component_ref: string;
  command_type: string;
  command_id?: string;
  arguments?: NamedValue[];
  delay_time?: number;
};

/** Commands that run at the same time; the next item of the sequence waits for all of them. */
export type ConcurrentCommands = { command_list: CommandUnit[]; delay_time?: number };

export type SequenceItem = CommandUnit | ConcurrentCommands;

export type RoISIdentifier = { code: string; authority?: string; codebook_ref?: string; version?: string };

export type ParameterProfile = {
  name: string;
  data_type_ref: RoISIdentifier;
  default_value?: string;
  description?: string;
};

export type MessageProfile = { name: string; results?: ParameterProfile[] };

export type CommandMessageProfile = MessageProfile & {
  arguments?: ParameterProfile[];
  timeout?: number | null;
};

export type ComponentProfile = {
  identifier: RoISIdentifier;
  name: string;
  function?: "actuation" | "sensing" | "function" | null;
  sub_component_profiles?: string[];
  command_profiles?: CommandMessageProfile[];
  query_profiles?: MessageProfile[];
  event_profiles?: MessageProfile[];
  parameter_profiles?: ParameterProfile[];
};

export type EngineProfile = {
  identifier: RoISIdentifier;
  sub_profiles?: EngineProfile[];
  component_ids?: string[];
  parameter_profiles?: ParameterProfile[];
};

/** Result of get_profile: the tree of engines, and the profile of each component by its reference. */
export interface Profile {
  readonly profile: EngineProfile | null;
  readonly component_profiles: { readonly [componentRef: string]: ComponentProfile };
}

/** Notification: a command has ended; it comes exactly once. */
export interface Completed {
  readonly command_id: string;
  readonly status: CompletedStatus;
}

/** Notification: an event happened. */
export interface RoISEvent {
  readonly event_id: string;
  readonly event_type: string;
  readonly subscribe_id: string;
  readonly expire: string;
  readonly results: readonly NamedValue[];
}

/** Notification: an engine or component reports a fault. */
export interface RoISFault {
  readonly error_id: string;
  readonly error_type: string;
}

/** An operation ended with a return code other than OK. */
export class RoISError extends Error {
  override readonly name = "RoISError";
  readonly returnCode: ReturnCode;
  readonly method: string;

  constructor(returnCode: ReturnCode, method: string) {
    super(`${method}: ${returnCode}`);
    this.returnCode = returnCode;
    this.method = method;
  }
}

/** Returns the text of the result called `name`, or undefined when it is not there. */
export function resultValue(results: readonly NamedValue[], name: string): string | undefined {
  return results.find((result) => result.name === name)?.value;
}

/** Reads a value of type `T[]`: a JSON array of strings. Anything else gives an empty list. */
export function listValue(text: string | undefined): string[] {
  try {
    const value: unknown = JSON.parse(text ?? "");
    return Array.isArray(value) ? value.filter((item) => typeof item === "string") : [];
  } catch {
    return [];
  }
}

export const textField = (object: JsonObject, name: string): string => {
  const value = object[name];
  return typeof value === "string" ? value : "";
};

export const listField = <T>(object: JsonObject, name: string): T[] => {
  const value: Json | undefined = object[name];
  return Array.isArray(value) ? (value as T[]) : [];
};
