/** Errors in RoIS terms; those of the connection are in `jsonrpc/session.ts`. */

import type { CompletedStatus, ReturnCode } from "./generated/types.ts";

/** An operation ended with a return code other than OK. */
export class RoISError extends Error {
  override readonly name = "RoISError";
  readonly returnCode: ReturnCode;
  /** The method that was called, such as `rois.command.bind`. */
  readonly method: string;
  /** Why, in a sentence of the gateway or the component; empty where the gateway speaks the base wire alone. */
  readonly reason: string;

  /** @param asked what was asked of it, `(robot/navigation)`, for a person */
  constructor(returnCode: ReturnCode, method: string, asked = "", reason = "") {
    super(`${method}${asked}: ${returnCode}${reason && ` (${reason})`}`);
    this.returnCode = returnCode;
    this.method = method;
    this.reason = reason;
  }
}

/** A command was accepted and did not end well. */
export class CommandFailed extends Error {
  override readonly name = "CommandFailed";
  /** ABORT: it was stopped, or a command before it in the sequence failed. */
  readonly status: CompletedStatus;
  readonly commandId: string;
  /** Why, in a sentence of the component or the gateway; empty where the gateway speaks the base wire alone. */
  readonly reason: string;

  constructor(command: string, commandId: string, status: CompletedStatus, reason = "") {
    super(`${command}: ${status}${reason && ` (${reason})`}`);
    this.status = status;
    this.commandId = commandId;
    this.reason = reason;
  }
}

/** A value does not fit its type. */
export class ValueError extends Error {
  override readonly name = "ValueError";
}

/** The gateway's response does not fit its method. */
export class InvalidMessage extends Error {
  override readonly name = "InvalidMessage";
}
