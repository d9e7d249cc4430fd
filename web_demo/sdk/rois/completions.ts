/** Who waits for which command to end. */

import { ConnectionLost, RequestTimeout } from "../jsonrpc/session.ts";
import type { Completed } from "./types.ts";

/** How many commands are remembered; the oldest is forgotten first. */
const REMEMBERED = 256;

interface Entry {
  outcome: Completed | Error | null;
  readonly waiting: Set<(outcome: Completed | Error) => void>;
}

/** Remembers commands from before they are sent, so that no `completed` can be missed. */
export class Completions {
  readonly #entries = new Map<string, Entry>();

  /** Call it before the command is sent. */
  expect(commandId: string): void {
    if (this.#entries.has(commandId)) return;
    this.#entries.set(commandId, { outcome: null, waiting: new Set() });
    for (const [oldest] of this.#entries) {
      if (this.#entries.size <= REMEMBERED) break;
      this.#settle(oldest, new RequestTimeout(`${oldest}: forgotten, too many commands are unfinished`));
      this.#entries.delete(oldest);
    }
  }

  /** The command was refused: nobody need wait for it. */
  forget(commandId: string): void {
    this.#entries.delete(commandId);
  }

  completed(completed: Completed): void {
    this.#settle(completed.command_id, completed);
  }

  /** The session is gone; what it would have reported is lost. */
  lost(): void {
    for (const commandId of this.#entries.keys()) {
      this.#settle(
        commandId,
        new ConnectionLost(`${commandId}: the connection ended before the command did`),
      );
    }
  }

  /** @throws ConnectionLost | RequestTimeout */
  wait(commandId: string, timeout: number): Promise<Completed> {
    this.expect(commandId);
    const entry = this.#entries.get(commandId);
    return new Promise((resolve, reject) => {
      const settle = (outcome: Completed | Error): void => {
        clearTimeout(timer);
        entry?.waiting.delete(settle);
        if (outcome instanceof Error) reject(outcome);
        else resolve(outcome);
      };
      const timer = setTimeout(
        () => settle(new RequestTimeout(`${commandId}: not completed within ${timeout} ms`)),
        timeout,
      );
      if (entry?.outcome) settle(entry.outcome);
      else entry?.waiting.add(settle);
    });
  }

  #settle(commandId: string, outcome: Completed | Error): void {
    const entry = this.#entries.get(commandId);
    if (!entry || entry.outcome) return;
    entry.outcome = outcome;
    for (const settle of [...entry.waiting]) settle(outcome);
  }
}
