/** Control of components: requests, hand-over, and STOP. */

import { ConnectionLost, RequestTimeout } from "../jsonrpc/session.ts";
import type { Bindings } from "./bindings.ts";
import { RoISError } from "./errors.ts";
import type {
  LeaseChangedNotification,
  LeaseDeclinedNotification,
  LeaseRequestedNotification,
  LeaseStatus,
  LeaseWithdrawnNotification,
  StoppedNotification,
} from "./generated/types.ts";
import type { Link } from "./link.ts";
import { mayConcern } from "./profile_change.ts";
import type { Stops } from "./stops.ts";

/** Notifications of leases. */
export interface ControlEvents {
  "openrois.lease.changed": LeaseChangedNotification;
  "openrois.lease.requested": LeaseRequestedNotification;
  "openrois.lease.declined": LeaseDeclinedNotification;
  "openrois.lease.withdrawn": LeaseWithdrawnNotification;
  /** A person has stopped a body, so that programs have to wait; or, with an empty `by`, has handed it back. */
  "openrois.lease.stopped": StoppedNotification;
}

/** The leases of a client, see `docs/explanation/control.md`. Everything throws as the other operations of a client do. */
export class Control {
  readonly #client: Link;
  readonly #bindings: Bindings;
  readonly #stops: Stops;
  /** Checks of waiting requests: each finds out whether it still waits. */
  readonly #checks = new Set<() => void>();
  /** The ids of the STOPs that this client was told, by engine. */
  readonly #told = new Map<string, string>();

  constructor(client: Link, bindings: Bindings, stops: Stops) {
    this.#client = client;
    this.#bindings = bindings;
    this.#stops = stops;
    this.on("openrois.lease.stopped", ({ engine_id: engineId, by = "", stop_id: stopId = "" }) => {
      this.#noteStop(engineId, by === "" ? "" : stopId);
      if (by !== "") stops.handleStopped(engineId);
    });
    client.on("state", ({ name }) => {
      if (name !== "connected") this.#told.clear();
    });
  }

  #noteStop(engineId: string, stopId: string): void {
    if (stopId === "") this.#told.delete(engineId);
    else this.#told.set(engineId, stopId);
  }

  /** Listens to one kind of notification of leases and returns the function that ends it. */
  on<Name extends keyof ControlEvents>(
    name: Name,
    listener: (notification: ControlEvents[Name]) => void,
  ): () => void {
    return this.#client.on("notification", ({ method, params }) => {
      if (method === name) listener(params as unknown as ControlEvents[Name]);
    });
  }

  /** Returns the lease of a component; from then on `openrois.lease.changed` reports its changes. */
  async status(componentRef: string): Promise<LeaseStatus | null> {
    const { lease = null } = await this.#client.call("openrois.lease.query", { component_ref: componentRef });
    const [engineId = ""] = componentRef.split("/");
    this.#noteStop(engineId, lease?.stop_id ?? "");
    return lease;
  }

  /**
   * Asks the holder of a component for it, and resolves once it is bound; a free component is bound at once.
   *
   * @param wait stay in line when the holder says no, until it is given back or one leaves
   * @throws RoISError (OUT_OF_RESOURCES: the holder said no, or nothing in time, or this client has left the line;
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
      const check = (): void => {
        if (!kept) return;
        this.#waits(componentRef).then((waits) => {
          if (waits) return;
          kept = false;
          refuse("this application has left the line for it");
        }, reject);
      };
      this.#checks.add(check);
      const ends = [
        () => this.#checks.delete(check),
        // It may be gone, also for a moment, or not be shown to this application any more.
        client.on("profile_changed", (change) => {
          if (mayConcern(change, componentRef)) check();
        }),
        this.on("openrois.lease.changed", (lease) => {
          if (lease.component_ref === componentRef && lease.state === "MINE") resolve();
        }),
        this.on("openrois.lease.declined", (lease) => {
          if (lease.component_ref !== componentRef) return;
          if (wait) check();
          else refuse(lease.reason);
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

  /** Leaves the line for a component: requests that wait in this client are refused. */
  async leave(componentRef: string): Promise<void> {
    await this.#client.call("openrois.lease.leave", { component_ref: componentRef });
    for (const check of this.#checks) check();
  }

  /** Whether this client stands in line for a component, or holds it by now. */
  async #waits(componentRef: string): Promise<boolean> {
    const { state = "FREE", position = 0 } = (await this.status(componentRef)) ?? {};
    return state === "MINE" || position > 0;
  }

  /** Hands the component over to the requesting application; running commands end with ABORT. */
  async grant(requestId: string): Promise<void> {
    await this.#client.call("openrois.lease.grant", { request_id: requestId });
  }

  /** Declines a request and keeps the component. */
  async decline(requestId: string): Promise<void> {
    await this.#client.call("openrois.lease.decline", { request_id: requestId });
  }

  /** Takes a component from its holder, as an administrator; running commands end with ABORT. */
  async take(componentRef: string): Promise<void> {
    await this.#client.call("openrois.lease.take", { component_ref: componentRef });
    this.#bindings.gained(componentRef);
  }

  /**
   * Takes a component with its part for a time from an application of lower rank, which has it back afterwards; what runs
   * there ends with ABORT. A free component is simply bound. Borrow it again to have it for longer, and give it back as
   * soon as it is not needed.
   *
   * @param seconds for which it is taken; what the gateway is configured for (30 s) unless given
   * @param forOneCommand give it back by itself when the next `start` has ended
   * @returns the lease now
   * @throws RoISError (OUT_OF_RESOURCES: its holder is not of lower rank, request it instead) | RpcError: the gateway knows no loans
   */
  async borrow(
    componentRef: string,
    { seconds, forOneCommand = false }: { readonly seconds?: number; readonly forOneCommand?: boolean } = {},
  ): Promise<LeaseStatus | null> {
    const { call } = this.#client;
    const params = {
      component_ref: componentRef,
      ...(seconds !== undefined && { duration_ms: Math.round(seconds * 1000) }),
      ...(forOneCommand && { ends_with: "COMMAND" as const }),
    };
    const late = (): void => this.#bindings.giveBack(call, componentRef);
    const { lease = null } = await call("openrois.lease.borrow", params, late);
    this.#bindings.gained(componentRef);
    return lease;
  }

  /** Releases all of the part of a component: an application from which it was taken for a time has it back. */
  async giveBack(componentRef: string): Promise<void> {
    this.#bindings.gaveBack(componentRef);
    await this.#client.call("openrois.lease.give_back", { component_ref: componentRef });
  }

  /**
   * Stops everything that acts on an engine; without one, on every engine of which this application holds something,
   * or, as an administrator, sees something. Where it is a person's, programs wait then until a person calls
   * `releaseStop`. Works of `Client.bound` that still wait for their component, and of `unlessStopped`, do not begin.
   * It is no safety-rated emergency stop.
   *
   * @returns which components have stopped
   * @throws RoISError (ERROR: something did not say that it has stopped; UNSUPPORTED: nothing that acts there is in scope)
   */
  async stopAll(engineId?: string): Promise<readonly string[]> {
    const params = engineId === undefined ? {} : { engine_id: engineId };
    const stop = () => this.#client.call("openrois.stop_all", params);
    return (await this.#stops.stopEngine(engineId, stop)).stopped ?? [];
  }

  /**
   * Does what has to come before a command, such as borrowing a component or subscribing to its events. The command is to
   * be sent when it has resolved: where this client or a person stops the component meanwhile, it does not.
   *
   * @param undo is called with what came of it where that is of no use any more
   * @throws CommandFailed (ABORT: it was stopped before it began) | what `prepare` throws
   */
  unlessStopped<T>(
    componentRef: string,
    prepare: () => Promise<T>,
    undo?: (prepared: T) => Promise<void> | void,
  ): Promise<T> {
    return this.#stops.unlessStopped(componentRef, prepare, undo);
  }

  /**
   * Hands a body that a person has stopped back to programs, as a person; one that is not stopped stays so.
   * It ends the STOP that this client was told last, and no later one; where it was told none, whichever holds.
   *
   * @throws RoISError (OUT_OF_RESOURCES: it was stopped again meanwhile: look again, and hand it back anew; UNSUPPORTED: this application is a program, or nothing that acts there is in scope)
   */
  async releaseStop(engineId: string): Promise<void> {
    const stopId = this.#told.get(engineId);
    // One that is refused is asked for anew.
    this.#told.delete(engineId);
    const params = { engine_id: engineId, ...(stopId !== undefined && { stop_id: stopId }) };
    await this.#client.call("openrois.lease.release_stop", params);
  }
}
