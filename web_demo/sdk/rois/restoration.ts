/** Restores bindings and subscriptions, with retries. */

import { Backoff } from "./backoff.ts";
import type { BackoffOptions } from "./backoff.ts";
import type { Bindings } from "./bindings.ts";
import type { Renewal } from "./claims.ts";
import type { Call } from "./link.ts";
import type { Subscriptions } from "./subscriptions.ts";

/**
 * All are renewed when the profile has changed: an engine that left and came back has forgotten them. What is missing
 * is tried again after a while: no notification reports a component that was released, or that works again.
 */
export class Restoration {
  readonly #bindings: Bindings;
  readonly #subscriptions: Subscriptions;
  readonly #renewal: Renewal;
  readonly #backoff: Backoff;
  #wanted: { readonly call: Call; readonly all: boolean } | null = null;
  #running = false;
  /** Whether there is a session. */
  #live = false;
  #timer: ReturnType<typeof setTimeout> | undefined;

  constructor(bindings: Bindings, subscriptions: Subscriptions, renewal: Renewal, backoff?: BackoffOptions) {
    this.#bindings = bindings;
    this.#subscriptions = subscriptions;
    this.#renewal = renewal;
    this.#backoff = new Backoff(backoff);
  }

  /**
   * Restores claims in a new session. Bindings are the gateway's own and quick, and are waited for; subscriptions are
   * not: an engine that hangs must not delay the session.
   */
  async begin(call: Call): Promise<void> {
    this.#live = true;
    await this.#bindings.renew(call, this.#renewal, true);
    this.changed(call, false);
  }

  /** Restores after a change of the profile: all claims, or only the missing ones. */
  changed(call: Call, all = true): void {
    clearTimeout(this.#timer);
    if (all) this.#backoff.reset();
    this.#wanted = { call, all: all || this.#wanted?.all === true };
    if (!this.#running) void this.#run();
  }

  /** Stops, since the session and its claims are gone. */
  stop(): void {
    clearTimeout(this.#timer);
    this.#live = false;
    this.#wanted = null;
    this.#bindings.lost();
    this.#subscriptions.lost();
  }

  /** Runs one renewal at a time; a request meanwhile causes one more. */
  async #run(): Promise<void> {
    this.#running = true;
    for (let wanted = this.#nextRenewal(); wanted; wanted = this.#nextRenewal()) {
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

  #nextRenewal(): { readonly call: Call; readonly all: boolean } | null {
    const wanted = this.#wanted;
    this.#wanted = null;
    return wanted;
  }
}
