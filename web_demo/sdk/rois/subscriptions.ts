/** Subscriptions that outlive the session in which they were made. */

import type { RoISEvent } from "./types.ts";

export interface Subscription {
  /** Ends the subscription, also on the gateway while it can be reached. */
  cancel(): Promise<void>;
}

/** The two operations of the wire. */
export interface EventOperations {
  subscribe(eventType: string, condition: string): Promise<string>;
  unsubscribe(subscribeId: string): Promise<void>;
}

interface Entry {
  readonly eventType: string;
  readonly condition: string;
  readonly listener: (event: RoISEvent) => void;
  subscribeId: string | null;
}

/**
 * Routes events to listeners and makes every subscription anew when asked to.
 *
 * A lost engine takes its subscriptions with it, and the only sign is `profile_changed`; so they are renewed on each.
 * The old id counts until the new one is there: no event is lost and none is delivered twice.
 */
export class Subscriptions {
  readonly #operations: EventOperations;
  readonly #entries = new Set<Entry>();

  constructor(operations: EventOperations) {
    this.#operations = operations;
  }

  async add(eventType: string, condition: string, listener: Entry["listener"]): Promise<Subscription> {
    const subscribeId = await this.#operations.subscribe(eventType, condition);
    const entry: Entry = { eventType, condition, listener, subscribeId };
    this.#entries.add(entry);
    return { cancel: () => this.#cancel(entry) };
  }

  deliver(event: RoISEvent): void {
    for (const entry of this.#entries) if (entry.subscribeId === event.subscribe_id) entry.listener(event);
  }

  /** The session that knew the ids is gone. */
  lost(): void {
    for (const entry of this.#entries) entry.subscribeId = null;
  }

  /** Subscribes all again. What is refused now is tried again at the next renewal. */
  async renew(): Promise<void> {
    await Promise.allSettled([...this.#entries].map((entry) => this.#renew(entry)));
  }

  async #renew(entry: Entry): Promise<void> {
    const old = entry.subscribeId;
    entry.subscribeId = await this.#operations.subscribe(entry.eventType, entry.condition);
    if (!this.#entries.has(entry)) await this.#operations.unsubscribe(entry.subscribeId);
    if (old !== null) await this.#operations.unsubscribe(old);
  }

  async #cancel(entry: Entry): Promise<void> {
    this.#entries.delete(entry);
    if (entry.subscribeId !== null)
      await this.#operations.unsubscribe(entry.subscribeId).catch(() => undefined);
  }
}
