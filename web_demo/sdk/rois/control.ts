/** Who controls which component: asking for it, handing it over, and stopping everything. */

import { ConnectionLost, RequestTimeout } from "../jsonrpc/session.ts";
import type { Bindings } from "./bindings.ts";
import { RoISError } from "./errors.ts";
import type {
  LeaseChangedNotification,
  LeaseDeclinedNotification,
  LeaseRequestedNotification,
  LeaseStatus,
  LeaseWithdrawnNotification,
} from "./generated/types.ts";
import type { Link } from "./link.ts";

/** What is told of leases. */
export interface ControlEvents {
  "openrois.lease.changed": LeaseChangedNotification;
  "openrois.lease.requested": LeaseRequestedNotification;
  "openrois.lease.declined": LeaseDeclinedNotification;
  "openrois.lease.withdrawn": LeaseWithdrawnNotification;
}

/** The leases of a client, see `docs/control.md`. Everything throws as the other operations of a client do. */
export class Control {
  readonly #client: Link;
  readonly #bindings: Bindings;
  /** What looks, for each request that waits, whether it still does. */
  readonly #looks = new Set<() => void>();

  constructor(client: Link, bindings: Bindings) {
    this.#client = client;
    this.#bindings = bindings;
    this.on("openrois.lease.changed", ({ component_ref: componentRef, state }) => {
      if (state === "HELD" && componentRef !== undefined) bindings.taken(componentRef);
    });
  }

  /** Listens to one kind of notification of leases; the function that comes back ends it. */
  on<Name extends keyof ControlEvents>(
    name: Name,
    listener: (told: ControlEvents[Name]) => void,
  ): () => void {
    return this.#client.on("notification", ({ method, params }) => {
      if (method === name) listener(params as unknown as ControlEvents[Name]);
    });
  }

  /** Returns who controls a component; from then on `openrois.lease.changed` tells when that changes. */
  async status(componentRef: string): Promise<LeaseStatus | null> {
    return (await this.#client.call("openrois.lease.query", { component_ref: componentRef })).lease ?? null;
  }

  /**
   * Asks the holder of a component for it, and resolves once it is bound; of a free one nobody is asked.
   *
   * @param wait stay in line when the holder says no, until it is given back or one leaves
   * @throws RoISError (OUT_OF_RESOURCES: the holder said no, or nothing in time, or one has left the line;
   *   UNSUPPORTED: there is no such component) | RequestTimeout (nothing is asked any more) | ConnectionLost
   */
  async request(componentRef: string, { wait = false }: { readonly wait?: boolean } = {}): Promise<void> {
    const client = this.#client;
    /** Whether the gateway may have a place in line for it, or the component. */
    let kept = false;
    const giveUp = (): void => {
      this.leave(componentRef).catch(() => undefined);
      // It may have become ours in the same moment.
      this.#bindings.giveBack(client.call, componentRef);
    };
    let stop = (): void => undefined;
    const granted = new Promise<void>((resolve, reject) => {
      const refuse = (reason: string): void =>
        reject(new RoISError("OUT_OF_RESOURCES", "openrois.lease.request", `(${componentRef})`, reason));
      const look = (): void => {
        if (!kept) return;
        this.#waits(componentRef).then((waits) => {
          if (waits) return;
          kept = false;
          refuse("one stands in line for it no more");
        }, reject);
      };
      this.#looks.add(look);
      const ends = [
        () => this.#looks.delete(look),
        // It may be gone, also for a moment, or not be shown to this application any more.
        client.on("profile_changed", look),
        this.on("openrois.lease.changed", (told) => {
          if (told.component_ref === componentRef && told.state === "MINE") resolve();
        }),
        this.on("openrois.lease.declined", (told) => {
          if (told.component_ref !== componentRef) return;
          if (wait) look();
          else refuse(told.reason);
        }),
        client.on("state", ({ name }) => {
          if (name !== "connected")
            reject(new ConnectionLost("openrois.lease.request: the connection ended"));
        }),
      ];
      stop = () => ends.forEach((end) => end());
    });
    granted.catch(() => undefined);
    try {
      const { lease } = await client
        .call("openrois.lease.request", { component_ref: componentRef }, giveUp)
        .catch((error: unknown) => {
          // What had no answer may have been begun all the same, and may begin later.
          kept = error instanceof RequestTimeout;
          throw error;
        });
      kept = true;
      if (lease?.state !== "MINE") await granted;
      this.#bindings.gained(componentRef);
    } catch (error) {
      if (kept) giveUp();
      throw error;
    } finally {
      stop();
    }
  }

  /** Asks for a component no more: whoever waits for it in this client is refused. */
  async leave(componentRef: string): Promise<void> {
    await this.#client.call("openrois.lease.leave", { component_ref: componentRef });
    for (const look of this.#looks) look();
  }

  /** Whether one stands in line for a component, or has it by now. */
  async #waits(componentRef: string): Promise<boolean> {
    const { state = "FREE", position = 0 } = (await this.status(componentRef)) ?? {};
    return state === "MINE" || position > 0;
  }

  /** Lets who asks have the component; what runs there ends with ABORT. */
  async grant(requestId: string): Promise<void> {
    await this.#client.call("openrois.lease.grant", { request_id: requestId });
  }

  /** Keeps the component that somebody asks for. */
  async decline(requestId: string): Promise<void> {
    await this.#client.call("openrois.lease.decline", { request_id: requestId });
  }

  /** Binds a component, as an administrator, whoever holds it; what runs there ends with ABORT. */
  async take(componentRef: string): Promise<void> {
    await this.#client.call("openrois.lease.take", { component_ref: componentRef });
    this.#bindings.gained(componentRef);
  }

  /**
   * Stops everything that acts on an engine; without one, on every engine of which this application may stop
   * something. It is no safety-rated emergency stop.
   *
   * @returns which components have stopped
   * @throws RoISError (ERROR: something did not say that it has stopped; OUT_OF_RESOURCES: one holds nothing there)
   */
  async stopAll(engineId?: string): Promise<readonly string[]> {
    const params = engineId === undefined ? {} : { engine_id: engineId };
    return (await this.#client.call("openrois.stop_all", params)).stopped ?? [];
  }
}
