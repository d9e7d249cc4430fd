/** Parts that this page has taken over for a time, and takes again for as long as it uses them. */

import { RoISError } from "../../sdk/index.ts";
import type { Client } from "../../sdk/index.ts";
import type { PartLeases } from "./part_leases.ts";

/** One part by the component that represents it, held until the promise of `release` has resolved. */
export interface HeldPart {
  readonly componentRef: string;
  release(): Promise<void>;
}

/** Seconds for which a part is taken over at a time, and milliseconds after which it is taken again if it is used. */
const LOAN = 30;
const RENEWAL = 10_000;

export class PartLoans {
  readonly #client: Client;
  readonly #leases: PartLeases;
  readonly #isUsed: () => boolean;
  /** The components by which parts are held for a time. */
  readonly #refs = new Set<string>();
  /** Applications from which nothing can be taken over: they do not rank lower. */
  readonly #equals = new Set<string>();
  #renewing: ReturnType<typeof setInterval> | undefined;

  /** @param isUsed returns whether the visitor has used the page a moment ago */
  constructor(client: Client, leases: PartLeases, isUsed: () => boolean) {
    this.#client = client;
    this.#leases = leases;
    this.#isUsed = isUsed;
  }

  /** Whether something may be taken over from an application: that was not refused yet. */
  mayTakeFrom(holder: string): boolean {
    return !this.#equals.has(holder);
  }

  has(componentRef: string): boolean {
    return this.#refs.has(componentRef);
  }

  /** Another body is shown: what was refused may be granted there. */
  reset(): void {
    this.#equals.clear();
  }

  /**
   * Takes a part for a time from an application of lower rank.
   *
   * @throws RoISError (OUT_OF_RESOURCES: its holder does not rank lower)
   */
  async borrow(componentRef: string): Promise<HeldPart> {
    const { holder = "" } = this.#leases.partOf(componentRef) ?? {};
    try {
      await this.#extend(componentRef);
    } catch (error) {
      if (error instanceof RoISError && error.returnCode === "OUT_OF_RESOURCES") this.#equals.add(holder);
      throw error;
    }
    this.#refs.add(componentRef);
    this.#renewing ??= setInterval(() => this.#renew(), RENEWAL);
    const release = async (): Promise<void> => {
      this.drop(componentRef);
      this.#leases.noteReleased(componentRef);
      await this.#client.control.giveBack(componentRef).catch(() => undefined);
    };
    return { componentRef, release };
  }

  /** Notes that a part is held no more: it is not taken again. */
  drop(componentRef: string): void {
    this.#refs.delete(componentRef);
    if (this.#refs.size > 0) return;
    clearInterval(this.#renewing);
    this.#renewing = undefined;
  }

  /** Where the page is not used the time ends, and the lender has the part back. */
  #renew(): void {
    if (!this.#isUsed()) return;
    // Where that fails the gateway tells what has become of it.
    for (const ref of this.#refs) this.#extend(ref).catch(() => undefined);
  }

  async #extend(componentRef: string): Promise<void> {
    const lease = await this.#client.control.borrow(componentRef, { seconds: LOAN });
    if (lease) this.#leases.note(componentRef, lease);
  }
}
