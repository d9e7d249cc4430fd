/** Going on where a lost connection ended: the token for it, and the commands whose end is not known meanwhile. */

import { RpcError } from "../jsonrpc/session.ts";
import type { Completions } from "./completions.ts";
import { RoISError } from "./errors.ts";
import type { Call } from "./link.ts";

/** Milliseconds between two attempts while the gateway takes the lost connection for alive. */
const RETRY = 1000;

/** Commands that one can ask about. */
const MOST = 1024;

const EXTENSION = "openrois.lease";

/** What a client does about a lost connection beside making another one. */
export class Resumption {
  readonly #completions: Completions;
  readonly #resumed: (refs: readonly string[]) => void;
  #token = "";
  #former = "";
  #grace = 0;
  #orphans: readonly string[] = [];
  #deadline: ReturnType<typeof setTimeout> | undefined;
  #retry: ReturnType<typeof setTimeout> | undefined;

  /** @param resumed what is held again, later than `begin`: the gateway had taken the lost connection for alive */
  constructor(completions: Completions, resumed: (refs: readonly string[]) => void) {
    this.#completions = completions;
    this.#resumed = resumed;
  }

  /** There is a new session: returns what it holds of the lost one. */
  async begin(call: Call, extensions: readonly string[] | null): Promise<readonly string[]> {
    if (!extensions?.includes(EXTENSION)) {
      this.#giveUp();
      return [];
    }
    const refs = this.#former === "" ? [] : await this.#resume(call);
    if (this.#former !== "") this.#retry = setTimeout(() => void this.#tryAgain(call), RETRY);
    else if (this.#token === "") await this.#ask(call);
    return refs;
  }

  /** The session is gone. */
  ended(closed: boolean): void {
    clearTimeout(this.#retry);
    if (!closed && this.#token !== "") {
      this.#former = this.#token;
      this.#token = "";
      this.#orphans = this.#completions.unfinished.slice(0, MOST);
      clearTimeout(this.#deadline);
      this.#deadline = setTimeout(() => this.#giveUp(), this.#grace);
    } else if (closed || this.#former === "") {
      this.#token = "";
      this.#giveUp();
      this.#completions.lost();
    }
  }

  async #resume(call: Call): Promise<readonly string[]> {
    try {
      const params = { token: this.#former, command_ids: [...this.#orphans] };
      const resumed = await call("openrois.lease.resume", params);
      clearTimeout(this.#deadline);
      this.#keep(resumed);
      this.#former = "";
      this.#orphans = [];
      this.#completions.lost(resumed.forgotten ?? []);
      return (resumed.leases ?? []).map((lease) => lease.component_ref);
    } catch (error) {
      if (!(error instanceof RoISError || error instanceof RpcError)) throw error;
      if (!(error instanceof RoISError && error.returnCode === "OUT_OF_RESOURCES")) this.#giveUp();
      return [];
    }
  }

  async #tryAgain(call: Call): Promise<void> {
    const refs = await this.begin(call, [EXTENSION]).catch(() => []);
    if (refs.length > 0) this.#resumed(refs);
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

  /** Nobody tells of the commands of the lost session any more. */
  #giveUp(): void {
    clearTimeout(this.#deadline);
    const orphans = this.#orphans;
    this.#former = "";
    this.#orphans = [];
    this.#completions.lost(orphans);
  }
}
