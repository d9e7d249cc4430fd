/** Bindings (reservations) that outlive the session in which they were made. */

import type { BindingClaim, Renewal } from "./claims.ts";
import { RoISError } from "./errors.ts";
import type { LeaseChangedNotification } from "./generated/types.ts";
import type { Call } from "./link.ts";
import type { Stops } from "./stops.ts";

/**
 * `unknown`: its session is gone. `lost`: it could not be made again, and `lost` was emitted. `lent`: another application
 * has it for a time, and it comes back by itself.
 */
type State = "held" | "unknown" | "lost" | "lent";

/** Components that this application has bound. A lost engine ends bindings, and so does a lost session. */
export class Bindings {
  readonly #states = new Map<string, State>();
  /** Components bound until they are released. */
  readonly #lasting = new Set<string>();
  /** Number of works that need each component now. */
  readonly #uses = new Map<string, number>();
  readonly #turns = new Map<string, Promise<unknown>>();
  readonly #stops: Stops;

  constructor(stops: Stops) {
    this.#stops = stops;
  }

  /** Binds until it is released. */
  async bind(call: Call, componentRef: string): Promise<void> {
    this.#count(componentRef, 1);
    try {
      await this.#bind(call, componentRef);
      this.#lasting.add(componentRef);
    } finally {
      this.#count(componentRef, -1);
    }
  }

  /** Binds a component that meets a condition, until it is released. */
  async bindAny(call: Call, condition: string): Promise<string> {
    const { component_ref: componentRef = "" } = await call(
      "rois.command.bind_any",
      { condition },
      ({ component_ref = "" }) => this.giveBack(call, component_ref),
    );
    this.#lasting.add(componentRef);
    this.#states.set(componentRef, "held");
    return componentRef;
  }

  /** Removes a lasting binding; returns whether no work of `during` needs the component now. */
  delete(componentRef: string): boolean {
    this.#lasting.delete(componentRef);
    if (this.#uses.has(componentRef)) return false;
    this.#states.delete(componentRef);
    return true;
  }

  clear(): void {
    this.#lasting.clear();
    this.#states.clear();
  }

  /**
   * Binds for as long as the work lasts; where works overlap, the last one releases.
   *
   * @throws CommandFailed (ABORT: it was stopped before it began) | what `hold` and the work throw
   */
  async during<T>(call: Call, componentRef: string, work: () => Promise<T>): Promise<T> {
    const drop = (): Promise<void> => this.drop(call, componentRef);
    await this.#stops.unlessStopped(componentRef, () => this.hold(call, componentRef), drop);
    try {
      return await work();
    } finally {
      await drop();
    }
  }

  /** Binds for one more work, until `drop`. */
  async hold(call: Call, componentRef: string): Promise<void> {
    this.#count(componentRef, 1);
    try {
      await this.#inTurn(componentRef, () => this.#bind(call, componentRef));
    } catch (error) {
      await this.drop(call, componentRef);
      throw error;
    }
  }

  /** Releases what no work needs any more. Never rejects. */
  async drop(call: Call, componentRef: string): Promise<void> {
    this.#count(componentRef, -1);
    await this.#inTurn(componentRef, async () => {
      if (this.#uses.has(componentRef) || this.#lasting.has(componentRef)) return;
      this.#states.delete(componentRef);
      await call("rois.command.release", { component_ref: componentRef });
    }).catch(() => undefined);
  }

  /** Adds a granted component, bound until it is released. */
  gained(componentRef: string): void {
    this.#lasting.add(componentRef);
    this.#states.set(componentRef, "held");
  }

  /** Removes a component that was given back with its part. */
  gaveBack(componentRef: string): void {
    this.#lasting.delete(componentRef);
    this.#states.delete(componentRef);
  }

  /** Follows the gateway's notification of the holder; returns whether something is to be bound again. */
  holderChanged(lease: LeaseChangedNotification, renewal: Renewal): boolean {
    const { component_ref: componentRef = "", holder = "", return_ms: returnMs = 0, reason } = lease;
    const state = this.#states.get(componentRef);
    if (state !== "held" && state !== "lent") return false;
    const claim: BindingClaim = { kind: "binding", componentRef };
    switch (lease.state) {
      case "MINE":
        this.#states.set(componentRef, "held");
        if (state === "lent") renewal.restored(claim);
        return false;
      case "FREE":
        // It does not come back by itself.
        if (state === "lent") this.#states.set(componentRef, "unknown");
        return state === "lent";
      case "HELD":
        if ((lease.return_position ?? 0) === 0) {
          this.gaveBack(componentRef);
          const reasons = `another application holds it now: ${reason}`;
          const error = new RoISError("OUT_OF_RESOURCES", "openrois.lease", `(${componentRef})`, reasons);
          renewal.lost({ ...claim, error });
        } else if (state === "held") {
          this.#states.set(componentRef, "lent");
          renewal.lent({ ...claim, holder, returnMs });
        }
    }
    return false;
  }

  /** Releases those bindings of the session that are not needed any more. */
  resumed(call: Call, refs: readonly string[]): void {
    for (const componentRef of refs) if (!this.#states.has(componentRef)) this.giveBack(call, componentRef);
  }

  /** Marks all bindings as unknown, since their session is gone. */
  lost(): void {
    for (const [componentRef, state] of this.#states) {
      if (state === "held" || state === "lent") this.#states.set(componentRef, "unknown");
    }
  }

  /** Whether a needed component is not held, and does not come back by itself. */
  get incomplete(): boolean {
    return [...this.#states.values()].some((state) => state !== "held" && state !== "lent");
  }

  /** Binds again what is missing, and what may be; returns what that was. Never rejects. */
  async renew(
    call: Call,
    renewal: Renewal,
    isDoubtful: (componentRef: string) => boolean,
  ): Promise<readonly string[]> {
    const refs = [...this.#states].flatMap(([ref, state]) =>
      state !== "lent" && (state !== "held" || isDoubtful(ref)) ? [ref] : [],
    );
    await Promise.all(refs.map((ref) => this.#renew(call, ref, renewal)));
    return refs;
  }

  async #bind(call: Call, componentRef: string): Promise<void> {
    await call("rois.command.bind", { component_ref: componentRef }, () => this.giveBack(call, componentRef));
    this.#states.set(componentRef, "held");
  }

  /** Releases a component whose binding came after its caller gave up, unless it is needed otherwise. */
  giveBack(call: Call, componentRef: string): void {
    if (this.#uses.has(componentRef) || this.#lasting.has(componentRef)) return;
    call("rois.command.release", { component_ref: componentRef }).catch(() => undefined);
  }

  #count(componentRef: string, change: number): void {
    const uses = (this.#uses.get(componentRef) ?? 0) + change;
    if (uses > 0) this.#uses.set(componentRef, uses);
    else this.#uses.delete(componentRef);
  }

  /** Requests may be answered out of order: a release must not overtake the bind that follows it. */
  #inTurn<T>(componentRef: string, step: () => Promise<T>): Promise<T> {
    const result = (this.#turns.get(componentRef) ?? Promise.resolve()).then(step);
    this.#turns.set(
      componentRef,
      result.catch(() => undefined),
    );
    return result;
  }

  async #renew(call: Call, componentRef: string, renewal: Renewal): Promise<void> {
    const claim: BindingClaim = { kind: "binding", componentRef };
    try {
      await call("rois.command.bind", { component_ref: componentRef });
      const state = this.#states.get(componentRef);
      // Released while it was being bound: the release may have come too early.
      if (state === undefined)
        return void (await call("rois.command.release", { component_ref: componentRef }));
      this.#states.set(componentRef, "held");
      if (state !== "held") renewal.restored(claim);
    } catch (error) {
      // Whatever else goes wrong ends the session, or is tried again at the next change.
      if (!(error instanceof RoISError)) return;
      const state = this.#states.get(componentRef);
      if (state === undefined || state === "lost") return;
      this.#states.set(componentRef, "lost");
      renewal.lost({ ...claim, error });
    }
  }
}
