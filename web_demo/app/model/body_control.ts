/** Control of the parts that move the body, all or none: taking, requesting, taking over for a time, handing over. */

import { RoISError } from "../../sdk/index.ts";
import type { Client, LeaseRequestedNotification } from "../../sdk/index.ts";
import { PartLeases } from "./part_leases.ts";
import type { BodyPart } from "./part_leases.ts";
import { PartLoans } from "./part_loans.ts";
import type { HeldPart } from "./part_loans.ts";
import { amid, named } from "./plain_words.ts";

/** Gives back what was taken; a second call does nothing. */
export type GiveBack = () => void;

/** Control of the body, as this page sees it. */
export type ControlState =
  | { readonly kind: "free" }
  | {
      readonly kind: "mine";
      /** The application that has it back afterwards; empty where it is this page's in its own right. */
      readonly lender: string;
    }
  | {
      readonly kind: "other";
      readonly holder: string;
      readonly absent: boolean;
      /** It may rank lower than this page: taking over was not refused yet. */
      readonly mayTakeOver: boolean;
    }
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

/** The held parts, and how many works need them. */
interface Holding {
  uses: number;
  readonly parts: HeldPart[];
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
  #watched: readonly string[] = [];
  #present = false;
  readonly #leases: PartLeases;
  readonly #loans: PartLoans;
  #holding: Holding | null = null;
  #taking: Promise<Holding> | null = null;
  /** Parts that were taken over one by one. */
  readonly #single = new Map<string, HeldPart>();
  #stops = 0;
  #declined = false;
  /** The component that this page waits for; empty for none. */
  #waitsFor = "";
  /** Requests of other applications by their ids, the first one first. */
  readonly #requests = new Map<string, PendingRequest>();

  /**
   * @param onChange is called when `state`, `parts`, `nextRequest` or what `holderOf` says may have changed
   * @param isUsed returns whether the visitor has used the page a moment ago: what was taken over is kept for that long
   */
  constructor(client: Client, onChange: () => void, isUsed: () => boolean = () => true) {
    this.#client = client;
    this.#onChange = onChange;
    this.#leases = new PartLeases(client, (part) => {
      if (part.state === "other") this.#partLost(part, `${named(part.holder)} has control now.`);
      this.#onChange();
    });
    this.#loans = new PartLoans(client, this.#leases, isUsed);
    const { control } = client;
    control.on("openrois.lease.requested", (lease) => this.#addRequest(lease));
    control.on("openrois.lease.withdrawn", ({ request_id }) => this.#dropRequest(request_id));
    control.on("openrois.lease.declined", ({ component_ref }) => {
      if (component_ref !== this.#waitsFor) return;
      this.#declined = true;
      void this.#readLeases();
    });
    client.on("stopped", (isStopped) => {
      if (this.#refs.some(isStopped)) this.#stops += 1;
    });
    client.on("lost", (claim) => {
      // What another application has by now, its lease has told.
      if (claim.kind !== "binding" || claim.error.method !== "rois.command.bind") return;
      const part = this.#leases.partOf(claim.componentRef);
      if (part) this.#partLost(part, "Control was lost with the connection.");
    });
    client.on("state", ({ name }) => {
      // A loan ends with the connection.
      if (name === "connected") return;
      for (const part of this.#single.values()) void part.release();
      this.#single.clear();
      if (this.#holding?.parts.some(({ componentRef }) => this.#loans.has(componentRef))) {
        this.#giveBackAll();
        this.onLost("Control was lost with the connection.");
      }
    });
  }

  /**
   * @param refs the components that move the body, the one that represents all of them first; null while they are away
   * @param watched components that control does not need, and whose holders are shown all the same
   */
  setComponents(refs: readonly string[] | null, watched: readonly string[] = []): void {
    this.#present = refs !== null;
    if (refs !== null && [...refs, ...watched].join() !== [...this.#refs, ...this.#watched].join()) {
      this.#giveBackAll();
      for (const part of this.#single.values()) void part.release();
      this.#single.clear();
      this.#loans.reset();
      this.#refs = refs;
      this.#watched = watched.filter((ref) => !refs.includes(ref));
      this.#leases.setComponents([...this.#refs, ...this.#watched]);
    }
    void this.#readLeases([...this.#refs, ...this.#watched]);
  }

  /** Whether this page's rank counts: the gateway goes by its token. */
  get ranked(): boolean {
    return this.#leases.ranked;
  }

  set ranked(ranked: boolean) {
    this.#leases.ranked = ranked;
  }

  /** The parts of the body, those first that move it; none while it is away. */
  get parts(): readonly BodyPart[] {
    return this.#present ? this.#leases.all : [];
  }

  /** Whether a part can be taken over, as far as this page knows. */
  mayTakeOver({ state, holder }: BodyPart): boolean {
    return this.ranked && state === "other" && this.#loans.mayTakeFrom(holder);
  }

  /** Whether this page has taken a part over by itself, without control of all. */
  isTakenOver({ refs }: BodyPart): boolean {
    return this.#single.has(refs[0] ?? "");
  }

  get state(): ControlState {
    if (!this.#present) return { kind: "free" };
    const moving = this.#moving;
    if (this.#holding) {
      const lender = moving.find((part) => part.state === "mine" && part.lender !== "")?.lender ?? "";
      return { kind: "mine", lender };
    }
    const waited = moving.find(({ refs }) => refs.includes(this.#waitsFor));
    const others = moving.filter(({ state }) => state === "other");
    const part = waited ?? others.find((other) => !this.mayTakeOver(other)) ?? others[0];
    if (!part) return { kind: "free" };
    const { holder, position, absent } = part;
    if (position > 0) return { kind: "waiting", holder, position, declined: this.#declined };
    if (part.state !== "other") return { kind: "free" };
    return { kind: "other", holder, absent, mayTakeOver: this.mayTakeOver(part) };
  }

  /** How often the body was stopped since the page was opened, as far as it knows. */
  get stops(): number {
    return this.#stops;
  }

  /** Names an application that has some of what control needs; empty where that is none. */
  get hindrance(): string {
    const control = this.state;
    return control.kind === "other" || control.kind === "waiting" ? named(control.holder) : "";
  }

  /** Names the application that has the part of this component; empty where that is none, or this page. */
  holderOf(componentRef: string | null): string {
    const part = this.#present ? this.#leases.partOf(componentRef) : undefined;
    return part?.state === "other" ? named(part.holder) : "";
  }

  /** The request that is to be answered next, and how many wait behind it; null without one. */
  get nextRequest(): { readonly subject: string; readonly more: number } | null {
    const [first] = this.#requests.values();
    const subject = this.#leases.nameOf(first?.lease.subject ?? "");
    return first ? { subject: named(subject), more: this.#requests.size - 1 } : null;
  }

  /**
   * Takes all parts of the body, or none; where several works have taken them, the last one gives them back.
   *
   * @throws BodyTaken | CommandFailed (ABORT: the body was stopped meanwhile) | what binding throws
   */
  takeControl(): Promise<GiveBack> {
    return this.#take(false);
  }

  /**
   * The same, and takes for a time what an application of lower rank holds; that has it back afterwards.
   *
   * @throws BodyTaken: its holder does not rank lower | what borrowing throws
   */
  takeOver(): Promise<GiveBack> {
    return this.#take(true);
  }

  async #take(borrows: boolean): Promise<GiveBack> {
    if (!this.#holding) {
      const hold = (): Promise<Holding> => this.#holdAll(borrows);
      this.#taking ??= this.#client.control
        .unlessStopped(this.#refs[0] ?? "", hold, ({ parts }) => this.#release(parts))
        .finally(() => (this.#taking = null));
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
   * The same, and asks an application that does not rank lower for the part that it holds: waits in line until that is given
   * back or handed over. It goes on waiting where the body is stopped meanwhile.
   *
   * @throws RoISError (OUT_OF_RESOURCES: this page has left the line) | what `take` throws
   */
  async requestControl(): Promise<GiveBack> {
    const asked: string[] = [];
    this.#declined = false;
    try {
      for (;;) {
        try {
          return await this.takeOver();
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
    const asked = this.#leases.partOf(request.lease.component_ref)?.refs ?? [];
    const isAsked = ({ componentRef }: HeldPart): boolean => asked.includes(componentRef);
    for (const part of parts) if (!isAsked(part)) await part.release();
    const why = await this.#client.control.grant(id).then(
      () => `You have handed over control to ${amid(named(this.#leases.nameOf(request.lease.subject)))}.`,
      () => "The request had ended already. Control was given back.",
    );
    for (const part of parts) if (isAsked(part)) void part.release();
    if (holding) this.onLost(why);
    await this.#readLeases();
  }

  /** Gives control back to the application from which it was taken over. */
  handBack(): void {
    const control = this.state;
    if (!this.#holding || control.kind !== "mine") return;
    this.#giveBackAll();
    this.onLost(`You have handed control back to ${amid(named(control.lender))}.`);
    this.#onChange();
  }

  /**
   * Takes one part for a time from an application of lower rank, until `handBackPart`.
   *
   * @throws BodyTaken: its holder does not rank lower | what borrowing throws
   */
  async takePart({ refs: [ref = ""] }: BodyPart): Promise<void> {
    if (this.#single.has(ref)) return;
    try {
      this.#single.set(ref, await this.#loans.borrow(ref));
    } catch (error) {
      throw this.#explain(error, ref);
    } finally {
      this.#onChange();
    }
  }

  /** Gives one part back that was taken over by itself. */
  async handBackPart({ refs: [ref = ""] }: BodyPart): Promise<void> {
    const part = this.#single.get(ref);
    this.#single.delete(ref);
    await part?.release();
    await this.#readLeases();
  }

  /** The parts that move the body. */
  get #moving(): readonly BodyPart[] {
    return this.#leases.all.filter(({ refs: [ref = ""] }) => this.#refs.includes(ref));
  }

  async #holdAll(borrows: boolean): Promise<Holding> {
    const refs = this.#refs;
    const parts: HeldPart[] = [];
    for (const part of this.#moving) {
      const [componentRef = ""] = part.refs;
      try {
        const isLoan = borrows && this.mayTakeOver(part);
        parts.push(await (isLoan ? this.#loans.borrow(componentRef) : this.#bind(componentRef)));
        this.#requireUnchanged(refs, parts);
      } catch (error) {
        await this.#release(parts);
        await this.#readLeases(refs);
        throw this.#explain(error, componentRef);
      }
    }
    return { uses: 0, parts };
  }

  /** Returns who has a part, where that is why it cannot be held. */
  #explain(error: unknown, componentRef: string): unknown {
    const isBusy = error instanceof RoISError && error.returnCode === "OUT_OF_RESOURCES";
    return isBusy ? new BodyTaken(componentRef, this.#leases.partOf(componentRef)?.holder ?? "") : error;
  }

  /** Checks that no part was lost, and the avatar not changed, while further parts were bound. */
  #requireUnchanged(refs: readonly string[], parts: readonly HeldPart[]): void {
    if (refs !== this.#refs) throw new Error("Another body was chosen.");
    for (const { componentRef } of parts) {
      const { state, holder = "" } = this.#leases.partOf(componentRef) ?? {};
      if (state === "other") throw new BodyTaken(componentRef, holder);
    }
  }

  /** Binds the component that represents a part: from then on no other application gets anything of it. */
  #bind(componentRef: string): Promise<HeldPart> {
    return new Promise((resolve, reject) => {
      const over = this.#client.bound(componentRef, () => {
        this.#leases.noteBound(componentRef);
        return new Promise<void>((end) => {
          const release = async (): Promise<void> => {
            end();
            await over.catch(() => undefined);
            if (!this.#single.has(componentRef)) this.#leases.noteReleased(componentRef);
          };
          resolve({ componentRef, release });
        });
      });
      over.catch(reject);
    });
  }

  /** Releases the parts from the last to the first, which represents all of them. */
  #giveBackAll(): void {
    const holding = this.#holding;
    this.#holding = null;
    if (!holding) return;
    void this.#release(holding.parts).then(() => this.#readLeases());
  }

  async #release(parts: readonly HeldPart[]): Promise<void> {
    for (const part of [...parts].reverse()) await part.release();
  }

  /** Gives up all parts when another application has one: they are of no use without it. */
  #partLost({ refs }: BodyPart, why: string): void {
    for (const ref of refs) {
      this.#single.delete(ref);
      this.#loans.drop(ref);
    }
    if (!this.#holding?.parts.some(({ componentRef }) => refs.includes(componentRef))) return;
    this.#giveBackAll();
    for (const id of [...this.#requests.keys()]) this.#dropRequest(id);
    this.onLost(why);
  }

  async #readLeases(
    refs: readonly string[] = [this.#waitsFor || (this.#refs[0] ?? "")].filter((ref) => ref !== ""),
  ): Promise<void> {
    if (this.#present) await this.#leases.read(refs);
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
