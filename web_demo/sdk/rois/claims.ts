/** What an application holds at its gateway, and loses with the session or the engine: bindings and subscriptions. */

import type { RoISError } from "./errors.ts";

/** A component that is bound for this application, or ought to be. */
export interface BindingClaim {
  readonly kind: "binding";
  readonly componentRef: string;
}

/** An event that this application is told of, or ought to be. */
export interface SubscriptionClaim {
  readonly kind: "subscription";
  readonly eventType: string;
  readonly condition: string;
}

/** What a client makes again by itself. */
export type Claim = BindingClaim | SubscriptionClaim;

/** A claim that could not be made again, and why. It is tried again after a while, and when the engines have changed. */
export type LostClaim = Claim & { readonly error: RoISError };

/** Hears what could not be made again, and what could after all; each is told once. */
export interface Renewal {
  lost(claim: LostClaim): void;
  restored(claim: Claim): void;
}
