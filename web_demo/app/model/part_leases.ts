/**
 * The parts of a body (legs, gaze, gesture, voice), and the application that holds each of them.
 *
 * The gateway says with a component's lease of which part it is; components of one part have one holder. Leases are read
 * once, and then told by the gateway.
 */

import type { Client, LeaseStatus } from "../../sdk/index.ts";
import { nameOfHolder } from "./plain_words.ts";

/** A part of a body, as this page sees it. */
export interface BodyPart {
  /** As the gateway calls it; of a component that is one by itself the component's own name. */
  readonly name: string;
  /** Its components that the page works with, the one that represents all of them first. */
  readonly refs: readonly string[];
  readonly state: "free" | "mine" | "other";
  /** The subject of its holder; empty where it has none. */
  readonly holder: string;
  /** The connection of the holder is lost. */
  readonly absent: boolean;
  /** The subject to which it goes back; empty where its holder has it in its own right. */
  readonly lender: string;
  /** Seconds until it goes back; 0 where it does not. */
  readonly seconds: number;
  /** Of this page among those that wait for it, from 1 on; 0 where it does not wait. */
  readonly position: number;
}

interface Lease {
  readonly status: LeaseStatus;
  /** The component of which it was told last. */
  readonly ref: string;
  /** When the part goes back, by `performance.now`. */
  readonly until: number;
}

export class PartLeases {
  readonly #client: Client;
  readonly #onChange: (part: BodyPart) => void;
  /** Whether this page's token names a rank that counts: then what shows no token is a program. */
  ranked = false;
  #refs: readonly string[] = [];
  /** The part of each component; a component of which the gateway names none is one by itself. */
  readonly #partOf = new Map<string, string>();
  readonly #leases = new Map<string, Lease>();
  /** The newest reading of each lease: gateways may answer an older one later. */
  readonly #readings = new Map<string, symbol>();

  /** @param onChange is called with a part of which the gateway has told something */
  constructor(client: Client, onChange: (part: BodyPart) => void) {
    this.#client = client;
    this.#onChange = onChange;
    client.control.on("openrois.lease.changed", ({ reason: _, ...status }) => {
      const { component_ref: ref = "" } = status;
      if (!this.#refs.includes(ref)) return;
      this.note(ref, status);
      const part = this.partOf(ref);
      if (part) this.#onChange(part);
    });
  }

  /** What the page calls a subject: where visitors have tokens, what shows none is a program. */
  nameOf(subject: string): string {
    return nameOfHolder(subject, this.ranked);
  }

  setComponents(refs: readonly string[]): void {
    this.#refs = refs;
    this.#partOf.clear();
    this.#leases.clear();
  }

  get all(): readonly BodyPart[] {
    const parts = new Map<string, string[]>();
    for (const ref of this.#refs) {
      const key = this.#keyOf(ref);
      parts.set(key, [...(parts.get(key) ?? []), ref]);
    }
    return [...parts].map(([key, refs]) => this.#describe(key, refs));
  }

  /** The part of a component; undefined for a component that the page does not work with. */
  partOf(ref: string | null): BodyPart | undefined {
    return this.all.find(({ refs }) => ref !== null && refs.includes(ref));
  }

  /** Notes what the gateway says of one component: it holds for its whole part. */
  note(ref: string, status: LeaseStatus): void {
    if (status.part) this.#partOf.set(ref, status.part);
    const key = this.#keyOf(ref);
    const known = this.#leases.get(key);
    const isMine = known?.status.state === "MINE" && known.ref !== ref;
    // Of a part that is this page's by one component the others may be free, or come with it.
    if (isMine && (status.state === "FREE" || status.state === "MINE")) return;
    this.#leases.set(key, { status, ref, until: performance.now() + (status.return_ms ?? 0) });
  }

  /** Notes that this page has bound a component: a gateway sends no notifications of that. */
  noteBound(ref: string): void {
    const status = this.#leases.get(this.#keyOf(ref))?.status;
    if (status?.state !== "MINE") this.note(ref, { component_ref: ref, state: "MINE" });
  }

  /** Notes that this page has released a component: its part is free until the gateway says otherwise. */
  noteReleased(ref: string): void {
    if (this.#leases.get(this.#keyOf(ref))?.status.state === "MINE") this.#leases.delete(this.#keyOf(ref));
  }

  /** Reads leases; from then on their changes are notified. Gateways without leases have none. */
  async read(refs: readonly string[]): Promise<void> {
    const all = this.#refs;
    if (this.#client.state.name !== "connected") return;
    const read = async (ref: string): Promise<void> => {
      const reading = Symbol(ref);
      this.#readings.set(ref, reading);
      const status = await this.#client.control.status(ref).catch(() => null);
      const isNewest = all === this.#refs && reading === this.#readings.get(ref);
      if (status && isNewest) this.note(ref, status);
    };
    await Promise.all(refs.map(read));
  }

  #keyOf(ref: string): string {
    return this.#partOf.get(ref) ?? ref;
  }

  #describe(key: string, refs: readonly string[]): BodyPart {
    const lease = this.#leases.get(key);
    const { state = "FREE", holder = "", lender = "", position = 0 } = lease?.status ?? {};
    const seconds = Math.ceil(((lease?.until ?? 0) - performance.now()) / 1000);
    return {
      name: key.slice(key.lastIndexOf("/") + 1),
      refs,
      state: state === "FREE" ? "free" : state === "MINE" ? "mine" : "other",
      holder: state === "FREE" || state === "MINE" ? "" : this.nameOf(holder),
      absent: state === "ABSENT",
      lender: this.nameOf(lender),
      seconds: lender === "" ? 0 : Math.max(0, seconds),
      position,
    };
  }
}
