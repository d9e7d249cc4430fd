/** Control of all components that move the body, all or none: taking, requesting, and handing it over. */

import { RoISError } from "../../sdk/index.ts";
import type { Client, LeaseRequestedNotification, LeaseStatus } from "../../sdk/index.ts";
import { named } from "./plain_words.ts";

/** Gives back what was taken; a second call does nothing. */
export type GiveBack = () => void;

/** Control of the body, as this page sees it. */
export type ControlState =
  | { readonly kind: "free" | "mine" }
  | { readonly kind: "other"; readonly holder: string; readonly absent: boolean }
  | {
      readonly kind: "waiting";
      readonly holder: string;
      readonly position: number;
      /** The holder keeps it for now; this page stays in line. */
      readonly declined: boolean;
    };

/** Another application holds a part of the body. */
export class BodyTaken extends Error {
  readonly componentRef: string;

  constructor(componentRef: string, holder: string) {
    super(`${named(holder)} has control. Ask for it first.`);
    this.componentRef = componentRef;
  }
}

/** One component, held until the promise of `release` has resolved. */
interface Part {
  readonly componentRef: string;
  release(): Promise<void>;
}

/** The held parts, and how many works need them. */
interface Holding {
  uses: number;
  readonly parts: Part[];
}

/** A request of another application that waits for an answer. */
interface PendingRequest {
  readonly lease: LeaseRequestedNotification;
  readonly ending: ReturnType<typeof setTimeout>;
}

export class BodyControl {
  readonly #client: Client;
  readonly #onChange: () => void;
  /** Is called with a reason, a sentence, when control was lost without being given back. */
  onLost: (why: string) => void = () => undefined;
  #refs: readonly string[] = [];
  #present = false;
  readonly #leases = new Map<string, LeaseStatus>();
  /** The newest reading of each lease: gateways may answer an older one later. */
  readonly #readings = new Map<string, symbol>();
  #holding: Holding | null = null;
  #taking: Promise<Holding> | null = null;
  #declined = false;
  /** The component that this page waits for; empty for none. */
  #waitsFor = "";
  /** Requests of other applications by their ids, the first one first. */
  readonly #requests = new Map<string, PendingRequest>();

  /** @param onChange is called when `state`, `nextRequest` or what `holderOf` says may have changed */
  constructor(client: Client, onChange: () => void) {
    this.#client = client;
    this.#onChange = onChange;
    const { control } = client;
    control.on("openrois.lease.changed", (lease) => {
      const { component_ref: ref = "" } = lease;
      if (!this.#refs.includes(ref)) return;
      const { reason: _, ...status } = lease;
      this.#leases.set(ref, status);
      if (status.state === "HELD" || status.state === "ABSENT")
        this.#controlLost(ref, `${named(status.holder ?? "")} has control now.`);
      this.#onChange();
    });
    control.on("openrois.lease.requested", (lease) => this.#addRequest(lease));
    control.on("openrois.lease.withdrawn", ({ request_id }) => this.#dropRequest(request_id));
    control.on("openrois.lease.declined", ({ component_ref }) => {
      if (component_ref !== this.#waitsFor) return;
      this.#declined = true;
      void this.#readLeases();
    });
    client.on("lost", (claim) => {
      // What another application has by now, its lease has told.
      if (claim.kind === "binding" && claim.error.method === "rois.command.bind")
        this.#controlLost(claim.componentRef, "Control was lost with the connection.");
    });
  }

  /** @param refs the components that move the body, the one that represents all of them first; null while they are away */
  setComponents(refs: readonly string[] | null): void {
    this.#present = refs !== null;
    if (refs !== null && refs.join() !== this.#refs.join()) {
      this.#giveBackAll();
      this.#refs = refs;
      this.#leases.clear();
    }
    void this.#readLeases(this.#refs);
  }

  get state(): ControlState {
    if (!this.#present) return { kind: "free" };
    const lease = this.#leases.get(this.#waitsFor || (this.#refs[0] ?? ""));
    const { state = "FREE", holder = "", position = 0 } = lease ?? {};
    if (state === "MINE" || this.#holding) return { kind: "mine" };
    if (position > 0) return { kind: "waiting", holder, position, declined: this.#declined };
    if (state === "FREE") return { kind: "free" };
    return { kind: "other", holder, absent: state === "ABSENT" };
  }

  /** Names the application that has control of all, or of this component; empty where that is none, or this page. */
  holderOf(componentRef: string | null): string {
    const control = this.state;
    if (control.kind === "other" || control.kind === "waiting") return named(control.holder);
    const { state, holder = "" } = this.#leases.get(componentRef ?? "") ?? {};
    return this.#present && (state === "HELD" || state === "ABSENT") ? named(holder) : "";
  }

  /** The request that is to be answered next, and how many wait behind it; null without one. */
  get nextRequest(): { readonly subject: string; readonly more: number } | null {
    const [first] = this.#requests.values();
    return first ? { subject: named(first.lease.subject), more: this.#requests.size - 1 } : null;
  }

  /**
   * Takes all parts of the body, or none; where several works have taken them, the last one gives them back.
   *
   * @throws BodyTaken | what binding throws
   */
  async takeControl(): Promise<GiveBack> {
    if (!this.#holding) {
      this.#taking ??= this.#bindAll().finally(() => (this.#taking = null));
      this.#holding = await this.#taking;
    }
    const holding = this.#holding;
    holding.uses += 1;
    this.#onChange();
    let over = false;
    return () => {
      if (over) return;
      over = true;
      holding.uses -= 1;
      if (holding.uses === 0 && holding === this.#holding) this.#giveBackAll();
    };
  }

  /**
   * The same, and asks the application that holds a part of it: waits in line until that part is given back or handed over.
   *
   * @throws RoISError (OUT_OF_RESOURCES: this page has left the line) | what `take` throws
   */
  async requestControl(): Promise<GiveBack> {
    const asked: string[] = [];
    this.#declined = false;
    try {
      for (;;) {
        try {
          return await this.takeControl();
        } catch (error) {
          if (!(error instanceof BodyTaken) || asked.length > this.#refs.length) throw error;
          asked.push(error.componentRef);
          this.#waitsFor = error.componentRef;
          const granted = this.#client.control.request(error.componentRef, { wait: true });
          void this.#readLeases();
          await granted;
        }
      }
    } finally {
      this.#waitsFor = "";
      for (const ref of asked) void this.#client.release(ref).catch(() => undefined);
      void this.#readLeases();
    }
  }

  /** Asks a holder once more that has said no, while `request` waits. */
  async askAgain(): Promise<void> {
    this.#declined = false;
    if (this.#waitsFor === "") return;
    this.#client.control.request(this.#waitsFor, { wait: true }).catch(() => undefined);
    await this.#readLeases();
  }

  /** Leaves the line: `request` fails. */
  async leaveLine(): Promise<void> {
    if (this.#waitsFor !== "") await this.#client.control.leave(this.#waitsFor);
    await this.#readLeases();
  }

  /** Answers the next request. All parts are given up for it: a part is not handed over alone. */
  async answerRequest(grant: boolean): Promise<void> {
    const [[id, request] = []] = this.#requests;
    if (id === undefined || !request) return;
    this.#dropRequest(id);
    if (!grant) return this.#client.control.decline(id);
    const holding = this.#holding;
    this.#holding = null;
    const parts = [...(holding?.parts ?? [])].reverse();
    const isAsked = ({ componentRef }: Part): boolean => componentRef === request.lease.component_ref;
    for (const part of parts) if (!isAsked(part)) await part.release();
    const why = await this.#client.control.grant(id).then(
      () => `You have handed over control to ${named(request.lease.subject)}.`,
      () => "The request had ended already. Control was given back.",
    );
    for (const part of parts) if (isAsked(part)) void part.release();
    if (holding) this.onLost(why);
    await this.#readLeases();
  }

  async #bindAll(): Promise<Holding> {
    const refs = this.#refs;
    const parts: Part[] = [];
    for (const componentRef of refs) {
      try {
        parts.push(await this.#hold(componentRef));
        // A gateway sends an application no notifications of its own bindings.
        this.#leases.delete(componentRef);
        this.#requireUnchanged(refs, parts);
      } catch (error) {
        for (const part of parts.reverse()) await part.release();
        await this.#readLeases();
        if (error instanceof BodyTaken) throw error;
        const isBusy = error instanceof RoISError && error.returnCode === "OUT_OF_RESOURCES";
        throw isBusy ? new BodyTaken(componentRef, this.#leases.get(componentRef)?.holder ?? "") : error;
      }
    }
    return { uses: 0, parts };
  }

  /** Checks that no part was lost, and the avatar not changed, while further parts were bound. */
  #requireUnchanged(refs: readonly string[], parts: readonly Part[]): void {
    if (refs !== this.#refs) throw new Error("Another body was chosen.");
    for (const { componentRef } of parts) {
      const { state, holder = "" } = this.#leases.get(componentRef) ?? {};
      if (state === "HELD" || state === "ABSENT") throw new BodyTaken(componentRef, holder);
    }
  }

  #hold(componentRef: string): Promise<Part> {
    return new Promise((resolve, reject) => {
      const over = this.#client.bound(
        componentRef,
        () =>
          new Promise<void>((end) => {
            const release = async (): Promise<void> => {
              end();
              await over.catch(() => undefined);
            };
            resolve({ componentRef, release });
          }),
      );
      over.catch(reject);
    });
  }

  /** Releases the parts from the last to the first, which represents all of them. */
  #giveBackAll(): void {
    const holding = this.#holding;
    this.#holding = null;
    if (!holding) return;
    const release = async (): Promise<void> => {
      for (const part of [...holding.parts].reverse()) await part.release();
      await this.#readLeases();
    };
    void release();
  }

  /** Gives up all parts when another application has one: they are of no use without it. */
  #controlLost(componentRef: string, why: string): void {
    if (!this.#holding?.parts.some((part) => part.componentRef === componentRef)) return;
    this.#giveBackAll();
    for (const id of [...this.#requests.keys()]) this.#dropRequest(id);
    this.onLost(why);
  }

  /** Reads leases; from then on their changes are notified. Gateways without leases have none. */
  async #readLeases(
    refs: readonly string[] = [this.#waitsFor || (this.#refs[0] ?? "")].filter((ref) => ref !== ""),
  ): Promise<void> {
    const all = this.#refs;
    if (this.#present && this.#client.state.name === "connected") {
      const read = async (ref: string): Promise<void> => {
        const reading = Symbol(ref);
        this.#readings.set(ref, reading);
        const status = await this.#client.control.status(ref).catch(() => null);
        const isNewest = all === this.#refs && reading === this.#readings.get(ref);
        if (status && isNewest) this.#leases.set(ref, status);
      };
      await Promise.all(refs.map(read));
    }
    this.#onChange();
  }

  #addRequest(lease: LeaseRequestedNotification): void {
    if (!this.#refs.includes(lease.component_ref)) return;
    const { request_id: id, answer_ms: milliseconds } = lease;
    clearTimeout(this.#requests.get(id)?.ending);
    this.#requests.set(id, { lease, ending: setTimeout(() => this.#dropRequest(id), milliseconds) });
    this.#onChange();
  }

  #dropRequest(requestId: string): void {
    clearTimeout(this.#requests.get(requestId)?.ending);
    if (this.#requests.delete(requestId)) this.#onChange();
  }
}
