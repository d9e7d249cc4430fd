/** Waiters for the ends of commands. */

import { ConnectionLost, RequestTimeout } from "../jsonrpc/session.ts";
import type { Ended } from "./link.ts";

/** Ended commands that are remembered; the oldest is dropped first. */
const REMEMBERED = 1024;

type Outcome = Ended | Error;

/**
 * Remembers how commands ended, also without a waiter: `completed` may come together with the response that carries the
 * command's id.
 */
export class Completions {
  readonly #waiting = new Map<string, Set<(outcome: Outcome) => void>>();
  readonly #ended = new Map<string, Outcome>();

  /** Adds a command id; to be called before the command is sent. */
  expect(commandId: string): void {
    if (!this.#ended.has(commandId) && !this.#waiting.has(commandId)) this.#waiting.set(commandId, new Set());
  }

  /** Removes a command that was refused. */
  discardCommand(commandId: string): void {
    this.#waiting.delete(commandId);
  }

  completed(completed: Ended): void {
    this.#settle(completed.command_id, completed);
  }

  awaits(commandId: string): boolean {
    return this.#waiting.has(commandId);
  }

  /** The commands that have not ended. */
  get unfinished(): readonly string[] {
    return [...this.#waiting.keys()];
  }

  /** Fails the waiters of commands whose session is gone. */
  lost(commandIds = this.unfinished): void {
    for (const commandId of commandIds) {
      if (!this.#waiting.has(commandId)) continue;
      this.#settle(
        commandId,
        new ConnectionLost(`${commandId}: the connection ended before the command did`),
      );
    }
  }

  /**
   * @param within milliseconds to wait at most; without it as long as the session lives
   * @throws ConnectionLost | RequestTimeout
   */
  wait(commandId: string, within?: number): Promise<Ended> {
    return new Promise((resolve, reject) => {
      let timer: ReturnType<typeof setTimeout> | undefined;
      const settle = (outcome: Outcome): void => {
        clearTimeout(timer);
        if (outcome instanceof Error) reject(outcome);
        else resolve(outcome);
      };
      const ended = this.#ended.get(commandId);
      if (ended) return settle(ended);
      this.expect(commandId);
      const waiting = this.#waiting.get(commandId);
      waiting?.add(settle);
      if (within === undefined) return;
      timer = setTimeout(() => {
        waiting?.delete(settle);
        reject(new RequestTimeout(`${commandId}: not completed within ${within} ms`));
      }, within);
    });
  }

  #settle(commandId: string, outcome: Outcome): void {
    const waiting = this.#waiting.get(commandId);
    this.#waiting.delete(commandId);
    this.#ended.set(commandId, outcome);
    const oldest = this.#ended.keys().next();
    if (this.#ended.size > REMEMBERED && !oldest.done) this.#ended.delete(oldest.value);
    for (const settle of waiting ?? []) settle(outcome);
  }
}
