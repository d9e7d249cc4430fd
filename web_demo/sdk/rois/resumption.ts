/** Going on where a connection ended: the token for it, and how the commands ended of which nobody told meanwhile. */

import { RpcError } from "../jsonrpc/session.ts";
import type { Completions } from "./completions.ts";
import { RoISError } from "./errors.ts";
import type { Call } from "./link.ts";

/** Milliseconds after which commands are given up of which nobody tells: a gateway that has crashed is back by then. */
const PATIENCE = 30_000;

/** Commands that one can ask about at once. */
const MOST = 1024;
const AT_ONCE = 64;

/** The close code of a connection whose session another one has resumed: it is that one's now. */
const RESUMED = 4409;

const EXTENSION = "openrois.lease";

/**
 * What a client does about a connection that has ended beside making another one. The gateway lets it resume its
 * session, or else has been restarted, or waited long enough. Then its journal may know how commands have ended.
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

  /** There is a new session: returns what it holds of the lost one. */
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
    if (this.#token === "") await this.#ask(call);
    void this.#findEnds(call);
    return refs;
  }

  /** The session is gone; it is no more told of what was told before. */
  ended(closed: boolean, code?: number): void {
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
      this.#keep(resumed);
      this.#former = "";
      this.#orphans = [...(resumed.forgotten ?? []), ...this.#orphans.slice(MOST)];
      return (resumed.leases ?? []).map((lease) => lease.component_ref);
    } catch (error) {
      if (!(error instanceof RoISError || error instanceof RpcError)) throw error;
      this.#former = "";
      return [];
    }
  }

  /** Whoever may not hold anything needs no token, and some gateways keep nothing. */
  async #ask(call: Call): Promise<void> {
    try {
      this.#keep(await call("openrois.lease.token"));
    } catch (error) {
      if (!(error instanceof RoISError || error instanceof RpcError)) throw error;
    }
  }

  #keep(told: { readonly token?: string; readonly grace_ms?: number }): void {
    this.#token = told.token ?? "";
    this.#grace = told.grace_ms ?? 0;
  }

  /** Asks how those commands have ended of which nobody will tell by himself. */
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

  /** Asks twice: what is told of the command comes right behind the first answer, and so before the second. */
  async #findEnd(call: Call, commandId: string): Promise<void> {
    for (let turn = 0; turn < 2; turn++) {
      if (!this.#completions.awaits(commandId)) return;
      try {
        await call("rois.command.get_command_result", { command_id: commandId });
      } catch (error) {
        if (!(error instanceof RoISError || error instanceof RpcError)) throw error;
        // It failed, or did not end before the gateway did: that is told, too.
        if (error instanceof RoISError && error.returnCode === "ERROR") continue;
        break;
      }
    }
    this.#completions.lost([commandId]);
  }

  /** Nobody tells of the commands of the lost session any more. */
  #giveUp(): void {
    clearTimeout(this.#deadline);
    this.#deadline = undefined;
    const orphans = this.#orphans;
    this.#former = "";
    this.#orphans = [];
    this.#completions.lost(orphans);
  }
}
