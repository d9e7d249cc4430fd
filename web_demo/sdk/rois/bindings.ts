/** Bindings (reservations) that outlive the session in which they were made. */

import type { BindingClaim, Renewal } from "./claims.ts";
import { RoISError } from "./errors.ts";
import type { Call } from "./link.ts";

/** `unknown`: the session that held it is gone. `lost`: it could not be made again, and that was told. */
type State = "held" | "unknown" | "lost";

/** What this application has bound. A lost engine takes bindings with it, and so does a lost session. */
export class Bindings {
  readonly #states = new Map<string, State>();

  add(componentRef: string): void {
    this.#states.set(componentRef, "held");
  }

  delete(componentRef: string): void {
    this.#states.delete(componentRef);
  }

  clear(): void {
    this.#states.clear();
  }

  /** The session that held them is gone. */
  lost(): void {
    for (const [componentRef, state] of this.#states) {
      if (state === "held") this.#states.set(componentRef, "unknown");
    }
  }

  /** Something is wanted that is not held. */
  get incomplete(): boolean {
    return [...this.#states.values()].some((state) => state !== "held");
  }

  /** Binds again, all or only what is missing; what is bound stays so. Never rejects. */
  async renew(call: Call, renewal: Renewal, all: boolean): Promise<void> {
    const refs = [...this.#states].filter(([, state]) => all || state !== "held").map(([ref]) => ref);
    await Promise.all(refs.map((ref) => this.#renew(call, ref, renewal)));
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
