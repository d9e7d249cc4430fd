/** Control of all that moves the body, together or not at all: taking it, asking for it, handing it over. */

import { RoISError } from "../../sdk/index.ts";
import type { Client, LeaseRequestedNotification, LeaseStatus } from "../../sdk/index.ts";
import { named } from "./names.ts";

/** Ends what was begun; a second time it does nothing. */
export type GiveBack = () => void;

/** Who has control of the body, as this page sees it. */
export type Standing =
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

/** One component that is held until the promise of `release` has come true. */
interface Part {
  readonly componentRef: string;
  release(): Promise<void>;
}

/** All parts that are held, and how many works need them. */
interface Holding {
  uses: number;
  readonly parts: Part[];
}

/** A request of another application that waits for an answer. */
interface Asking {
  readonly told: LeaseRequestedNotification;
  readonly ending: ReturnType<typeof setTimeout>;
}

export class BodyControl {
  readonly #client: Client;
  readonly #onChange: () => void;
  /** Is told, in a sentence, that what was held is held no more, although no work has given it back. */
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
  readonly #asking = new Map<string, Asking>();

  /** @param onChange is called when `standing`, `asked` or what `isTaken` says may have changed */
  constructor(client: Client, onChange: () => void) {
    this.#client = client;
    this.#onChange = onChange;
    const { control } = client;
    control.on("openrois.lease.changed", (told) => {
      const { component_ref: ref = "" } = told;
      if (!this.#refs.includes(ref)) return;
      const { reason: _, ...status } = told;
      this.#leases.set(ref, status);
      if (status.state === "HELD" || status.state === "ABSENT")
        this.#lose(ref, `${named(status.holder ?? "")} has control now.`);
      this.#onChange();
    });
    control.on("openrois.lease.requested", (told) => this.#ask(told));
    control.on("openrois.lease.withdrawn", ({ request_id }) => this.#forget(request_id));
    control.on("openrois.lease.declined", ({ component_ref }) => {
      if (component_ref !== this.#waitsFor) return;
      this.#declined = true;
      void this.#look();
    });
    client.on("lost", (claim) => {
      if (claim.kind === "binding") this.#lose(claim.componentRef, "Control was lost with the connection.");
    });
  }

  /** @param refs the components that move the body, the one that stands for all first; null while they are away */
  setComponents(refs: readonly string[] | null): void {
    this.#present = refs !== null;
    if (refs !== null && refs.join() !== this.#refs.join()) {
      this.#giveBackAll();
      this.#refs = refs;
      this.#leases.clear();
    }
    void this.#look(this.#refs);
  }

  get standing(): Standing {
    if (!this.#present) return { kind: "free" };
    const seat = this.#leases.get(this.#waitsFor || (this.#refs[0] ?? ""));
    const { state = "FREE", holder = "", position = 0 } = seat ?? {};
    if (state === "MINE" || this.#holding) return { kind: "mine" };
    if (position > 0) return { kind: "waiting", holder, position, declined: this.#declined };
    if (state === "FREE") return { kind: "free" };
    return { kind: "other", holder, absent: state === "ABSENT" };
  }

  /** Names the application that has control of all, or of this component; empty where that is none, or this page. */
  takenBy(componentRef: string | null): string {
    const { standing } = this;
    if (standing.kind === "other" || standing.kind === "waiting") return named(standing.holder);
    const { state, holder = "" } = this.#leases.get(componentRef ?? "") ?? {};
    return this.#present && (state === "HELD" || state === "ABSENT") ? named(holder) : "";
  }

  /** The request that is to be answered next, and how many wait behind it; null without one. */
  get asked(): { readonly subject: string; readonly more: number } | null {
    const [first] = this.#asking.values();
    return first ? { subject: named(first.told.subject), more: this.#asking.size - 1 } : null;
  }

  /**
   * Takes all parts of the body, or none; where several works have taken them, the last one gives them back.
   *
   * @throws BodyTaken | what binding throws
   */
  async take(): Promise<GiveBack> {
    if (!this.#holding) {
      this.#taking ??= this.#takeAll().finally(() => (this.#taking = null));
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
  async request(): Promise<GiveBack> {
    const asked: string[] = [];
    this.#declined = false;
    try {
      for (;;) {
        try {
          return await this.take();
        } catch (error) {
          if (!(error instanceof BodyTaken) || asked.length > this.#refs.length) throw error;
          asked.push(error.componentRef);
          this.#waitsFor = error.componentRef;
          const granted = this.#client.control.request(error.componentRef, { wait: true });
          void this.#look();
          await granted;
        }
      }
    } finally {
      this.#waitsFor = "";
      for (const ref of asked) void this.#client.release(ref).catch(() => undefined);
      void this.#look();
    }
  }

  /** Asks a holder once more that has said no, while `request` waits. */
  async askAgain(): Promise<void> {
    this.#declined = false;
    if (this.#waitsFor === "") return;
    this.#client.control.request(this.#waitsFor, { wait: true }).catch(() => undefined);
    await this.#look();
  }

  /** Leaves the line: `request` fails. */
  async leave(): Promise<void> {
    if (this.#waitsFor !== "") await this.#client.control.leave(this.#waitsFor);
    await this.#look();
  }

  /** Answers the request that is to be answered next. A part is not handed over alone: all is given up for it. */
  async answer(grant: boolean): Promise<void> {
    const [[id, asking] = []] = this.#asking;
    if (id === undefined || !asking) return;
    this.#forget(id);
    if (!grant) return this.#client.control.decline(id);
    const holding = this.#holding;
    this.#holding = null;
    const parts = [...(holding?.parts ?? [])].reverse();
    const isAsked = ({ componentRef }: Part): boolean => componentRef === asking.told.component_ref;
    for (const part of parts) if (!isAsked(part)) await part.release();
    const why = await this.#client.control.grant(id).then(
      () => `You have handed over control to ${named(asking.told.subject)}.`,
      () => "The request had ended already. Control was given back.",
    );
    for (const part of parts) if (isAsked(part)) void part.release();
    if (holding) this.onLost(why);
    await this.#look();
  }

  async #takeAll(): Promise<Holding> {
    const refs = this.#refs;
    const parts: Part[] = [];
    for (const componentRef of refs) {
      try {
        parts.push(await this.#hold(componentRef));
        // A gateway tells an application nothing of what it has bound itself.
        this.#leases.delete(componentRef);
        this.#requireUnchanged(refs, parts);
      } catch (error) {
        for (const part of parts.reverse()) await part.release();
        await this.#look();
        if (error instanceof BodyTaken) throw error;
        const isBusy = error instanceof RoISError && error.returnCode === "OUT_OF_RESOURCES";
        throw isBusy ? new BodyTaken(componentRef, this.#leases.get(componentRef)?.holder ?? "") : error;
      }
    }
    return { uses: 0, parts };
  }

  /** Of what is bound one after the other, a part may be another's by now, and the avatar another one. */
  #requireUnchanged(refs: readonly string[], parts: readonly Part[]): void {
    if (refs !== this.#refs) throw new Error("Another avatar was chosen.");
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

  /** The parts are given back from the last to the first, which stands for all. */
  #giveBackAll(): void {
    const holding = this.#holding;
    this.#holding = null;
    if (!holding) return;
    const release = async (): Promise<void> => {
      for (const part of [...holding.parts].reverse()) await part.release();
      await this.#look();
    };
    void release();
  }

  /** Another application has a part: the others are of no use without it. */
  #lose(componentRef: string, why: string): void {
    if (!this.#holding?.parts.some((part) => part.componentRef === componentRef)) return;
    this.#giveBackAll();
    for (const id of [...this.#asking.keys()]) this.#forget(id);
    this.onLost(why);
  }

  /** Reads how things stand; from then on changes by others are told. Gateways without leases say nothing. */
  async #look(
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

  #ask(told: LeaseRequestedNotification): void {
    if (!this.#refs.includes(told.component_ref)) return;
    const { request_id: id, answer_ms: milliseconds } = told;
    clearTimeout(this.#asking.get(id)?.ending);
    this.#asking.set(id, { told, ending: setTimeout(() => this.#forget(id), milliseconds) });
    this.#onChange();
  }

  #forget(requestId: string): void {
    clearTimeout(this.#asking.get(requestId)?.ending);
    if (this.#asking.delete(requestId)) this.#onChange();
  }
}
