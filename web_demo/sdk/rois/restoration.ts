/** Makes bindings and subscriptions again, for as long as something is missing. */

import { Backoff } from "./backoff.ts";
import type { BackoffOptions } from "./backoff.ts";
import type { Bindings } from "./bindings.ts";
import type { Renewal } from "./claims.ts";
import type { Call } from "./link.ts";
import type { Subscriptions } from "./subscriptions.ts";

/**
 * All are renewed when the profile has changed: an engine that left and came back has forgotten them. What is missing
 * is tried again after a while: of a component that another application gives back, or that works again, nobody tells.
 */
export class Restoration {
  readonly #bindings: Bindings;
  readonly #subscriptions: Subscriptions;
  readonly #renewal: Renewal;
  readonly #backoff: Backoff;
  #wanted: { readonly call: Call; readonly all: boolean } | null = null;
  #running = false;
  /** There is a session. */
  #live = false;
  #timer: ReturnType<typeof setTimeout> | undefined;

  constructor(bindings: Bindings, subscriptions: Subscriptions, renewal: Renewal, backoff?: BackoffOptions) {
    this.#bindings = bindings;
    this.#subscriptions = subscriptions;
    this.#renewal = renewal;
    this.#backoff = new Backoff(backoff);
  }

  /**
   * There is a new session. Bindings are the gateway's own and quick, so that they are waited for; subscriptions are
   * not, and an engine that hangs holds up nobody.
   */
  async begin(call: Call): Promise<void> {
    this.#live = true;
    await this.#bindings.renew(call, this.#renewal, true);
    this.changed(call, false);
  }

  /** What is there may be another now; without `all` only what is missing is made again. */
  changed(call: Call, all = true): void {
    clearTimeout(this.#timer);
    if (all) this.#backoff.reset();
    this.#wanted = { call, all: all || this.#wanted?.all === true };
    if (!this.#running) void this.#run();
  }

  /** The session is gone, and with it all that was held. */
  stop(): void {
    clearTimeout(this.#timer);
    this.#live = false;
    this.#wanted = null;
    this.#bindings.lost();
    this.#subscriptions.lost();
  }

  /** One renewal at a time: what is asked for meanwhile is done once more. */
  async #run(): Promise<void> {
    this.#running = true;
    for (let wanted = this.#take(); wanted; wanted = this.#take()) {
      const { call, all } = wanted;
      await Promise.all([
        this.#bindings.renew(call, this.#renewal, all),
        this.#subscriptions.renew(call, this.#renewal, all),
      ]);
      if (this.#live && !this.#wanted && (this.#bindings.incomplete || this.#subscriptions.incomplete)) {
        this.#timer = setTimeout(() => this.changed(call, false), this.#backoff.next());
      }
    }
    this.#running = false;
  }

  #take(): { readonly call: Call; readonly all: boolean } | null {
    const wanted = this.#wanted;
    this.#wanted = null;
    return wanted;
  }
}
