/** Subscription that exists only while it is wanted. */

import type { Subscription } from "../../sdk/index.ts";

export class Wanted {
  readonly #onRefused: (error: unknown) => void;
  #subscribe: (() => Promise<Subscription>) | null = null;
  #wanted = false;
  #subscription: Promise<Subscription> | null = null;

  /** @param onRefused is called with the error of a refused subscription */
  constructor(onRefused: (error: unknown) => void = () => undefined) {
    this.#onRefused = onRefused;
  }

  get wanted(): boolean {
    return this.#wanted;
  }

  set wanted(wanted: boolean) {
    this.#wanted = wanted;
    this.#follow();
  }

  /** @param subscribe gets the event; null where there is none */
  from(subscribe: (() => Promise<Subscription>) | null): void {
    this.#cancel();
    this.#subscribe = subscribe;
    this.#follow();
  }

  #follow(): void {
    if (!this.#wanted || !this.#subscribe) return this.#cancel();
    if (this.#subscription) return;
    const subscription = this.#subscribe();
    this.#subscription = subscription;
    subscription.catch((error: unknown) => {
      if (this.#subscription !== subscription) return;
      this.#subscription = null;
      this.#onRefused(error);
    });
  }

  #cancel(): void {
    void this.#subscription?.then((subscription) => subscription.cancel()).catch(() => undefined);
    this.#subscription = null;
  }
}
