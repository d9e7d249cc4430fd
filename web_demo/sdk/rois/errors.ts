/** What can go wrong in RoIS terms. What can go wrong with the connection stands in `jsonrpc/session.ts`. */

import type { CompletedStatus, ReturnCode } from "./generated/types.ts";

/** An operation ended with a return code other than OK. */
export class RoISError extends Error {
  override readonly name = "RoISError";
  readonly returnCode: ReturnCode;
  /** The method that was called, such as `rois.command.bind`. */
  readonly method: string;

  /** @param asked what was asked of it, `(robot/navigation)`, for a person */
  constructor(returnCode: ReturnCode, method: string, asked = "") {
    super(`${method}${asked}: ${returnCode}`);
    this.returnCode = returnCode;
    this.method = method;
  }
}

/** A command was accepted and did not end well. */
export class CommandFailed extends Error {
  override readonly name = "CommandFailed";
  /** ABORT: it was stopped, or a command before it in the sequence failed. */
  readonly status: CompletedStatus;
  readonly commandId: string;

  constructor(command: string, commandId: string, status: CompletedStatus) {
    super(`${command}: ${status}`);
    this.status = status;
    this.commandId = commandId;
  }
}

/** A value does not fit its type. */
export class ValueError extends Error {
  override readonly name = "ValueError";
}

/** The gateway answered with something that is not what the method gives. */
export class InvalidMessage extends Error {
  override readonly name = "InvalidMessage";
}
