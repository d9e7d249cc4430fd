/** Restores bindings and subscriptions, with retries. */

import { Backoff } from "./backoff.ts";
import type { BackoffOptions } from "./backoff.ts";
import type { Bindings } from "./bindings.ts";
import type { Renewal } from "./claims.ts";
import type { Call } from "./link.ts";
import { mayConcern } from "./profile_change.ts";
import type { ProfileChange } from "./profile_change.ts";
import type { Subscriptions } from "./subscriptions.ts";

/**
 * What an engine that has changed was asked for is renewed: it may have left and come back, and have forgotten it. What
 * is missing is tried again after a while: no notification reports a component that was released, or that works again.
 */
interface Wanted {
  readonly call: Call;
  /** What has changed; null where only what is missing is restored. */
  readonly change: ProfileChange | null;
}

export class Restoration {
  readonly #bindings: Bindings;
  readonly #subscriptions: Subscriptions;
  readonly #renewal: Renewal;
  readonly #backoff: Backoff;
  #wanted: Wanted | null = null;
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
    const refs = await this.#bindings.renew(call, this.#renewal, () => true);
    // What was released meanwhile, before the application could send anything, the gateway does not know.
    this.#bindings.resumed(call, refs);
    this.changed(call, null);
  }

  /** Restores what is missing, and what engines that have changed may have forgotten. */
  changed(call: Call, change: ProfileChange | null): void {
    clearTimeout(this.#timer);
    if (change) this.#backoff.reset();
    this.#wanted = { call, change: both(this.#wanted?.change ?? null, change) };
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
      const { call, change } = wanted;
      const isDoubtful = (id: string): boolean => change !== null && mayConcern(change, id);
      await Promise.all([
        this.#bindings.renew(call, this.#renewal, isDoubtful),
        this.#subscriptions.renew(call, this.#renewal, isDoubtful),
      ]);
      if (this.#live && !this.#wanted && (this.#bindings.incomplete || this.#subscriptions.incomplete)) {
        this.#timer = setTimeout(() => this.changed(call, null), this.#backoff.next());
      }
    }
    this.#running = false;
  }

  #nextRenewal(): Wanted | null {
    const wanted = this.#wanted;
    this.#wanted = null;
    return wanted;
  }
}

function both(one: ProfileChange | null, other: ProfileChange | null): ProfileChange | null {
  if (one === null || other === null) return one ?? other;
  const named = one.engineIds.size > 0 && other.engineIds.size > 0;
  return { engineIds: new Set(named ? [...one.engineIds, ...other.engineIds] : []) };
}
