/** Outcomes of commands in words. Pure. */

import {
  CommandFailed,
  ConnectionLost,
  InvalidMessage,
  RequestTimeout,
  RoISError,
  RpcError,
} from "../../sdk/index.ts";
import type { CompletedStatus } from "../../sdk/index.ts";
import { isStop, plainReason } from "./plain_words.ts";

export interface Outcome {
  readonly state: "done" | "stopped" | "failed" | "refused";
  readonly text: string;
}

const BUSY = "another visitor has control";

/**
 * @param elapsed milliseconds from the start to the end
 * @param reason why it did not end OK, where one was given
 */
export function describeCompleted(status: CompletedStatus, elapsed: number, reason = ""): Outcome {
  const seconds = `${(elapsed / 1000).toFixed(1)} s`;
  const why = plainReason(reason);
  switch (status) {
    case "OK":
      return { state: "done", text: `done after ${seconds}` };
    case "ABORT":
      return { state: "stopped", text: why || `stopped after ${seconds}` };
    case "TIMEOUT":
      return { state: "failed", text: why || "it took too long" };
    default:
      return { state: "failed", text: `the body could not do it${why && `: ${why}`}` };
  }
}

/**
 * Waits for the end of a command and describes it.
 *
 * @param busy the sentence for a component that another session holds
 */
export async function describeEnd(command: Promise<void>, busy: string): Promise<Outcome> {
  const startedAt = Date.now();
  try {
    await command;
    return describeCompleted("OK", Date.now() - startedAt);
  } catch (error) {
    if (error instanceof CommandFailed)
      return describeCompleted(error.status, Date.now() - startedAt, error.reason);
    return describeFailure(error, busy);
  }
}

/** @param busy the sentence for a component that another session holds */
export function describeFailure(error: unknown, busy = BUSY): Outcome {
  if (error instanceof RoISError) {
    const why = plainReason(error.reason);
    if (error.returnCode === "OUT_OF_RESOURCES")
      return { state: "refused", text: isStop(error.reason) ? why : busy };
    return { state: "failed", text: `the body refused it${why && `: ${why}`}` };
  }
  if (error instanceof CommandFailed) {
    const why = plainReason(error.reason);
    return { state: "failed", text: why || "the body could not do it" };
  }
  return { state: "failed", text: failureWords(error) };
}

/** Words for errors of the SDK, whose own texts name methods, ids and codes for programmers. */
function failureWords(error: unknown): string {
  if (error instanceof ConnectionLost) return "the connection ended before the body had finished";
  if (error instanceof RequestTimeout) return "the gateway did not answer in time; try again";
  if (error instanceof RpcError)
    return "this gateway does not support it; run an OpenRoIS gateway of this version";
  if (error instanceof InvalidMessage)
    return "the gateway's answer cannot be read; run an OpenRoIS gateway of this version";
  return error instanceof Error ? error.message : String(error);
}
