/** Subscriptions that outlive the session in which they were made; events for listeners, and as async iterables. */

import { notifyListener } from "../jsonrpc/events.ts";
import type { Renewal, SubscriptionClaim } from "./claims.ts";
import { RoISError } from "./errors.ts";
import type { Call, RoISEvent } from "./link.ts";

/** A subscription, as `subscribe` returns it. */
export interface Subscription {
  /** Ends the subscription, also on the gateway while it can be reached. */
  cancel(): Promise<void>;
}

type Listener = (event: RoISEvent) => void;

/** Events of subscriptions whose ids are not known yet. */
const MAX_EARLY = 256;

interface Entry {
  readonly eventType: string;
  readonly condition: string;
  readonly listener: Listener;
  readonly onEnd: () => void;
  /** Null where there is none now; the session or the engine that knew it is gone. */
  subscribeId: string | null;
  /** Whether `lost` was emitted for it. */
  lost: boolean;
  /** While it is made again: the events that came by the old one, and may come by the new one too. */
  overlap: Set<string> | null;
}

/**
 * Routes events to listeners and makes every subscription anew when asked to.
 *
 * A lost engine takes its subscriptions with it, and the only sign is that the profile has changed; so they are renewed
 * then, all of them where the gateway does not say which engines have changed. The id of a subscription begins with that
 * of its engine. The old id counts until the new one is there: no event is lost and none is delivered twice.
 */
export class Subscriptions {
  readonly #entries = new Set<Entry>();
  /** Events before the response with their subscription id, which may come together. */
  #early: RoISEvent[] = [];
  #asking = 0;
  #session = 0;

  async add(
    call: Call,
    eventType: string,
    condition: string,
    listener: Listener,
    onEnd: () => void = () => undefined,
  ): Promise<Subscription> {
    const entry: Entry = {
      eventType,
      condition,
      listener,
      onEnd,
      subscribeId: null,
      lost: false,
      overlap: null,
    };
    await this.#subscribe(call, entry, () => this.#entries.add(entry));
    return { cancel: () => this.#cancel(call, entry) };
  }

  deliver(event: RoISEvent): void {
    let known = false;
    for (const entry of this.#entries) {
      if (entry.subscribeId !== event.subscribe_id) continue;
      known = true;
      entry.overlap?.add(event.event_id);
      notifyListener(event.event_type, entry.listener, event);
    }
    if (known || this.#asking === 0) return;
    if (this.#early.length === MAX_EARLY) this.#early.shift();
    this.#early.push(event);
  }

  /** Drops the ids, since their session is gone. */
  lost(): void {
    this.#session += 1;
    for (const entry of this.#entries) entry.subscribeId = null;
  }

  /** Whether a subscription is missing at the gateway. */
  get incomplete(): boolean {
    return [...this.#entries].some(({ subscribeId }) => subscribeId === null);
  }

  /** Subscribes again to what is missing, and to what may be. Never rejects. */
  async renew(call: Call, renewal: Renewal, isDoubtful: (subscribeId: string) => boolean): Promise<void> {
    const entries = [...this.#entries].filter(
      ({ subscribeId }) => subscribeId === null || isDoubtful(subscribeId),
    );
    await Promise.all(entries.map((entry) => this.#renew(call, entry, renewal)));
  }

  /** Ends all subscriptions. */
  endAll(): void {
    const entries = [...this.#entries];
    this.#entries.clear();
    for (const entry of entries) entry.onEnd();
  }

  async #renew(call: Call, entry: Entry, renewal: Renewal): Promise<void> {
    const { eventType, condition, subscribeId: old } = entry;
    const claim: SubscriptionClaim = { kind: "subscription", eventType, condition };
    try {
      await this.#subscribe(call, entry);
      if (!this.#entries.has(entry)) await this.#unsubscribe(call, entry.subscribeId);
      else if (old === null) renewal.restored(claim);
      entry.lost = false;
      await this.#unsubscribe(call, old);
    } catch (error) {
      // Whatever else goes wrong ends the session, or is tried again at the next change.
      if (!(error instanceof RoISError) || !this.#entries.has(entry)) return;
      // A component that does not work now refuses new subscriptions and keeps those it has.
      if (error.returnCode === "UNSUPPORTED") entry.subscribeId = null;
      if (entry.lost || entry.subscribeId !== null) return;
      entry.lost = true;
      renewal.lost({ ...claim, error });
    }
  }

  async #subscribe(call: Call, entry: Entry, succeeded: () => void = () => undefined): Promise<void> {
    const session = this.#session;
    this.#asking += 1;
    entry.overlap = new Set();
    try {
      const { eventType: event_type, condition } = entry;
      const { subscribe_id } = await call("rois.event.subscribe", { event_type, condition }, (late) =>
        this.#unsubscribe(call, late.subscribe_id ?? null),
      );
      // The session may have ended meanwhile.
      entry.subscribeId = session === this.#session ? (subscribe_id ?? "") : null;
      succeeded();
      if (this.#entries.has(entry)) this.#catchUp(entry);
    } finally {
      entry.overlap = null;
      this.#asking -= 1;
      if (this.#asking === 0) this.#early = [];
    }
  }

  #catchUp(entry: Entry): void {
    const mine = this.#early.filter((event) => event.subscribe_id === entry.subscribeId);
    this.#early = this.#early.filter((event) => !mine.includes(event));
    for (const event of mine)
      if (!entry.overlap?.has(event.event_id)) notifyListener(event.event_type, entry.listener, event);
  }

  async #cancel(call: Call, entry: Entry): Promise<void> {
    if (!this.#entries.delete(entry)) return;
    entry.onEnd();
    await this.#unsubscribe(call, entry.subscribeId);
  }

  async #unsubscribe(call: Call, subscribeId: string | null): Promise<void> {
    if (subscribeId === null) return;
    await call("rois.event.unsubscribe", { subscribe_id: subscribeId }).catch(() => undefined);
  }
}

/** Most events that wait for a slow reader; the oldest is dropped. */
const MAX_WAITING = 256;

type Subscribe = (listener: Listener, onEnd: () => void) => Promise<Subscription>;

/** Subscribes when the iteration begins; its end, or that of the client, ends the subscription. */
export async function* iterate(subscribe: Subscribe): AsyncGenerator<RoISEvent, void, void> {
  const waiting: RoISEvent[] = [];
  let ended = false;
  let wake = (): void => undefined;
  const subscription = await subscribe(
    (event) => {
      if (waiting.length === MAX_WAITING) waiting.shift();
      waiting.push(event);
      wake();
    },
    () => {
      ended = true;
      wake();
    },
  );
  try {
    for (;;) {
      const event = waiting.shift();
      if (event !== undefined) yield event;
      else if (ended) return;
      else await new Promise<void>((resolve) => (wake = resolve));
    }
  } finally {
    await subscription.cancel();
  }
}
