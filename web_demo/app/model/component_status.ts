/** Polls whether a component can be used, until it can. */

import { onlyComponent, resultValue, RoISError } from "../../sdk/index.ts";
import type { Client, ComponentStatus } from "../../sdk/index.ts";

/** Milliseconds between two questions while the component cannot be used. */
const ASK_AGAIN = 5000;

/** Null: there is no such component, or it cannot be asked. */
export type Availability = ComponentStatus | null;

export class ComponentWatch {
  readonly #client: Client;
  readonly #onChange: (status: Availability) => Promise<void> | void;
  #componentRef: string | null = null;
  #timer: ReturnType<typeof setTimeout> | undefined;
  #round = 0;

  /** @param onChange where its promise rejects, status and all that follows from it are asked again */
  constructor(client: Client, onChange: (status: Availability) => Promise<void> | void) {
    this.#client = client;
    this.#onChange = onChange;
  }

  /** Looks at another component, or at the same one anew; null at none. */
  watch(componentRef: string | null): void {
    this.#componentRef = componentRef;
    this.#round += 1;
    clearTimeout(this.#timer);
    if (componentRef === null) void this.#onChange(null);
    else void this.#ask(this.#round);
  }

  async #ask(round: number): Promise<void> {
    const status = await this.#status();
    if (round !== this.#round) return;
    const answered = await Promise.resolve(this.#onChange(status)).then(
      () => true,
      // What it does not have at all it will not have later.
      (error: unknown) => error instanceof RoISError && error.returnCode === "UNSUPPORTED",
    );
    if (round !== this.#round || (answered && isUsable(status))) return;
    this.#timer = setTimeout(() => void this.#ask(round), ASK_AGAIN);
  }

  async #status(): Promise<Availability> {
    if (this.#componentRef === null || this.#client.state.name !== "connected") return null;
    try {
      const results = await this.#client.query("component_status", onlyComponent(this.#componentRef));
      return (resultValue(results, "status") ?? null) as Availability;
    } catch {
      return null;
    }
  }
}

/** Whether a component can be used. BUSY counts: `bind` finds out whether this page may use it. */
export function isUsable(status: Availability): boolean {
  return status === "READY" || status === "BUSY" || status === "WARNING";
}
