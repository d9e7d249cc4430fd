/** Resumption of a session after a lost connection: its token, and the ends of unfinished commands. */

import { RpcError } from "../jsonrpc/session.ts";
import type { Completions } from "./completions.ts";
import { RoISError } from "./errors.ts";
import type { Call } from "./link.ts";

/** Milliseconds until unfinished commands are given up: a restarted gateway is back by then. */
const PATIENCE = 30_000;

/** Most commands in one request, and most requests at a time. */
const MOST = 1024;
const AT_ONCE = 64;

/** Queries for the end of a command that may still run at another gateway: each waits for some seconds. */
const QUERIES = 6;

/** Close code of a connection whose session was resumed by another one. */
const RESUMED = 4409;

const EXTENSION = "openrois.lease";

/**
 * Resumes the session of a lost connection in a new one. Where that fails, because the gateway was restarted or the
 * grace time is over, the gateway's journal may know how commands have ended.
 */
export class Resumption {
  readonly #completions: Completions;
  #extended = false;
  #token = "";
  #former = "";
  #grace = 0;
  #orphans: readonly string[] = [];
  #deadline: ReturnType<typeof setTimeout> | undefined;

  constructor(completions: Completions) {
    this.#completions = completions;
  }

  /** Resumes the lost session in a new one; returns the components that it still holds. */
  async begin(call: Call, extensions: readonly string[] | null): Promise<readonly string[]> {
    this.#extended = extensions?.includes(EXTENSION) === true;
    // An attempt that failed half way had a session, too.
    this.#former = this.#token || this.#former;
    this.#token = "";
    this.#orphans = this.#completions.unfinished;
    if (!this.#extended) {
      this.#giveUp();
      return [];
    }
    const refs = this.#former === "" ? [] : await this.#resume(call);
    if (this.#token === "") await this.#requestToken(call);
    void this.#findEnds(call);
    return refs;
  }

  /** Notes that the session is gone, and sets the deadline of its unfinished commands. */
  sessionEnded(closed: boolean, code?: number): void {
    if (code === RESUMED) this.#token = "";
    if (closed || !this.#extended) {
      this.#token = "";
      this.#giveUp();
      this.#completions.lost();
    } else if (this.#deadline === undefined) {
      this.#orphans = this.#completions.unfinished;
      this.#deadline = setTimeout(() => this.#giveUp(), Math.max(this.#grace, PATIENCE));
    }
  }

  async #resume(call: Call): Promise<readonly string[]> {
    try {
      const params = { token: this.#former, command_ids: this.#orphans.slice(0, MOST) };
      const resumed = await call("openrois.lease.resume", params);
      this.#keepToken(resumed);
      this.#former = "";
      this.#orphans = [...(resumed.forgotten ?? []), ...this.#orphans.slice(MOST)];
      return (resumed.leases ?? []).map((lease) => lease.component_ref);
    } catch (error) {
      if (!(error instanceof RoISError || error instanceof RpcError)) throw error;
      this.#former = "";
      return [];
    }
  }

  /** Requests a resumption token; refused to applications that may hold nothing, and unknown to some gateways. */
  async #requestToken(call: Call): Promise<void> {
    try {
      this.#keepToken(await call("openrois.lease.token"));
    } catch (error) {
      if (!(error instanceof RoISError || error instanceof RpcError)) throw error;
    }
  }

  #keepToken(granted: { readonly token?: string; readonly grace_ms?: number }): void {
    this.#token = granted.token ?? "";
    this.#grace = granted.grace_ms ?? 0;
  }

  /** Asks how the commands have ended that the gateway does not report by itself. */
  async #findEnds(call: Call): Promise<void> {
    const orphans = this.#orphans;
    try {
      for (let first = 0; first < orphans.length; first += AT_ONCE) {
        await Promise.all(orphans.slice(first, first + AT_ONCE).map((id) => this.#findEnd(call, id)));
      }
    } catch {
      // The connection is over, or does not answer: the next one is asked.
      return;
    }
    if (this.#orphans === orphans) this.#giveUp();
  }

  /** Asks until two answers: the notification of the end comes right behind the first one, before the second. */
  async #findEnd(call: Call, commandId: string): Promise<void> {
    for (let answers = 0, query = 0; answers < 2 && query < QUERIES; query++) {
      if (!this.#completions.awaits(commandId)) return;
      try {
        await call("rois.command.get_command_result", { command_id: commandId });
        answers += 1;
      } catch (error) {
        if (!(error instanceof RoISError || error instanceof RpcError)) throw error;
        const code = error instanceof RoISError ? error.returnCode : "";
        // The gateway that runs it may be lost. This one has waited for some seconds, and will know.
        if (code === "TIMEOUT") continue;
        // It failed, or did not end before the gateway did: a notification says so, too.
        if (code !== "ERROR") break;
        answers += 1;
      }
    }
    this.#completions.lost([commandId]);
  }

  /** Fails the unfinished commands of the lost session. */
  #giveUp(): void {
    clearTimeout(this.#deadline);
    this.#deadline = undefined;
    const orphans = this.#orphans;
    this.#former = "";
    this.#orphans = [];
    this.#completions.lost(orphans);
  }
}
