/** Claims of an application at its gateway, lost with the session or the engine: bindings and subscriptions. */

import type { RoISError } from "./errors.ts";

/** A component bound for this application, or to be bound again. */
export interface BindingClaim {
  readonly kind: "binding";
  readonly componentRef: string;
}

/** An event that this application subscribed to, or to be subscribed to again. */
export interface SubscriptionClaim {
  readonly kind: "subscription";
  readonly eventType: string;
  readonly condition: string;
}

/** What a client restores by itself. */
export type Claim = BindingClaim | SubscriptionClaim;

/** A claim that could not be made again, and why. It is tried again after a while, and when the engines have changed. */
export type LostClaim = Claim & { readonly error: RoISError };

/** A component that an application of higher rank has taken for a time; it comes back by itself. */
export type LentClaim = BindingClaim & {
  /** The subject of the application that has it. */
  readonly holder: string;
  /** Milliseconds after which it comes back at the latest, unless it is taken for longer. */
  readonly returnMs: number;
};

/** Is notified of claims that could not be restored or are lent, and of those that could later; of each once. */
export interface Renewal {
  lost(claim: LostClaim): void;
  lent(claim: LentClaim): void;
  restored(claim: Claim): void;
}
