/** What an answer means, in words for users who try a component out. Pure. */

import {
  CommandFailed,
  ConnectionLost,
  InvalidMessage,
  RequestTimeout,
  RoISError,
  RpcError,
} from "../../sdk/index.ts";
import type { CompletedStatus, ComponentStatus, Json, ReturnCode } from "../../sdk/index.ts";
import { plainReason } from "../model/plain_words.ts";

/** What was tried; some return codes mean something else for each. */
export type Attempt =
  | "bind"
  | "release"
  | "get_parameter"
  | "set_parameter"
  | "execute"
  | "result"
  | "query"
  | "subscribe"
  | "detail"
  | "error detail";

export interface Refusal {
  /** The return code, or what else ended the call, in one word. */
  readonly code: string;
  readonly sentence: string;
}

const ANYWHERE: Readonly<Record<Exclude<ReturnCode, "OK">, string>> = {
  ERROR: "The component could not do it. It may not be ready; its log tells more.",
  BAD_PARAMETER: "The engine does not accept what was sent.",
  UNSUPPORTED: "The component or this message of it is not there.",
  OUT_OF_RESOURCES: "The engine has no room for more of this.",
  TIMEOUT: "The component's adapter did not answer in time.",
};

const OF_ATTEMPT: Readonly<Partial<Record<Attempt, Partial<Record<ReturnCode, string>>>>> = {
  bind: { OUT_OF_RESOURCES: "Another application has bound this component." },
  set_parameter: {
    BAD_PARAMETER: "The component does not accept these values.",
    OUT_OF_RESOURCES:
      "Only the application that has bound this component may set its parameters: bind it first.",
  },
  execute: {
    BAD_PARAMETER: "The component does not accept these arguments.",
    UNSUPPORTED: "The component is not there, or does not have this command.",
    OUT_OF_RESOURCES: "Only the application that has bound this component may operate it: bind it first.",
  },
  result: { BAD_PARAMETER: "The engine does not remember this command any more." },
  query: { ERROR: "The component is not able to answer now." },
  subscribe: { ERROR: "The component cannot be listened to now." },
  detail: { BAD_PARAMETER: "The details of this event have expired." },
  "error detail": { BAD_PARAMETER: "The engine does not remember this error any more." },
};

const METHOD_NOT_FOUND = -32601;
const INVALID_PARAMS = -32602;

/** Returns what a failed call means. */
export function refusal(attempt: Attempt, error: unknown): Refusal {
  if (error instanceof RoISError) {
    const { returnCode: code } = error;
    const sentence = OF_ATTEMPT[attempt]?.[code] ?? (code === "OK" ? "" : ANYWHERE[code]);
    return { code, sentence: explained(sentence ?? "The engine refused it.", error.reason) };
  }
  if (error instanceof CommandFailed)
    return { code: error.status, sentence: `${completedWords(error.status, error.reason)}.` };
  if (error instanceof RpcError) return { code: String(error.code), sentence: protocolFault(error) };
  if (error instanceof ConnectionLost) {
    return {
      code: "connection lost",
      sentence: "The connection ended before the answer came. The page connects again by itself.",
    };
  }
  if (error instanceof RequestTimeout) {
    return { code: "no answer", sentence: "The gateway did not answer in time. Try again." };
  }
  if (error instanceof InvalidMessage) {
    return {
      code: "error",
      sentence: "The gateway's answer cannot be read. Run an OpenRoIS gateway of this version.",
    };
  }
  return { code: "error", sentence: error instanceof Error ? error.message : String(error) };
}

/** Returns what an answer means in general, and then why it came in this case, where a reason was given. */
function explained(general: string, reason: string): string {
  const why = plainReason(reason);
  return why ? `${general.split(/[.:]/, 1)[0] ?? ""}: ${why}` : general;
}

function protocolFault(error: RpcError): string {
  switch (error.code) {
    case METHOD_NOT_FOUND:
      return `This gateway does not serve ${error.method}. Run an OpenRoIS gateway of this version.`;
    case INVALID_PARAMS:
      return `The gateway does not understand the message: ${misfits(error.data) || "invalid params"}.`;
    default:
      return "The gateway failed while it did this; its log says why.";
  }
}

function misfits(data: Json | undefined): string {
  if (!Array.isArray(data)) return "";
  const one = (each: Json): string =>
    typeof each === "object" && each !== null && !Array.isArray(each)
      ? `${String(each["path"])}: ${String(each["message"])}`
      : String(each);
  return data.map(one).join("; ");
}

const COMPLETED: Readonly<Record<CompletedStatus, string>> = {
  OK: "Done",
  ERROR: "It was refused or went wrong (the adapter's log says why)",
  ABORT: "Ended before it was done",
  OUT_OF_RESOURCES: "The component has no room for it",
  TIMEOUT: "Not done in the time it may take",
};

/** Returns how a command ended, in words, and why where a reason was given. */
export function completedWords(status: CompletedStatus, reason = ""): string {
  const words = COMPLETED[status] ?? `Ended with ${String(status)}`;
  const why = plainReason(reason);
  return why ? `${words.replace(/ \(.*/, "")}: ${why}` : words;
}

const STATUS: Readonly<Record<ComponentStatus, string>> = {
  UNINITIALIZED: "Not initialized: it cannot be used yet",
  READY: "Ready",
  BUSY: "Busy: it is at work",
  WARNING: "It works, with a warning",
  ERROR: "It is broken and cannot be used",
};

/** Returns what a component's status means; null is one that is not known. */
export function statusWords(status: ComponentStatus | null): string {
  return status === null ? "Its status is not known yet" : (STATUS[status] ?? status);
}

/** Returns a time span as one would say it. */
export function tookWords(ms: number): string {
  if (ms < 10) return `${ms.toFixed(1)} ms`;
  return ms < 1000 ? `${ms.toFixed(0)} ms` : `${(ms / 1000).toFixed(ms < 10_000 ? 2 : 1)} s`;
}

/** Returns a time limit as one would say it. */
export function limitWords(ms: number): string {
  return ms < 1000 ? `${ms} ms` : `${ms / 1000} s`;
}
