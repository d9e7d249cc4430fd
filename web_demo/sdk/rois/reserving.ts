/**
 * Reserving a body: all components that an application needs of one engine, or none.
 *
 * Components are bound in the sorted order of their references. Of applications that try at the same moment one always
 * gets its body, unless an application that has its body holds a part of it. The others release what they have and try
 * again after a while, by chance. Nothing is held while they wait.
 */

import { Backoff } from "./backoff.ts";
import type { BackoffOptions } from "./backoff.ts";
import type { Bindings } from "./bindings.ts";
import { Body } from "./body.ts";
import type { AnyComponentClass, Reservation } from "./body.ts";
import { abilities, bodiesIn, bodiesOf, refsOf } from "./body_directory.ts";
import type { BodyInfo, BodyProfile } from "./body_directory.ts";
import type { Client } from "./client.ts";
import { codeOf } from "./discovery.ts";
import { DIRECTORY } from "./engine_directory.ts";
import type { EngineDirectory } from "./engine_directory.ts";
import { RoISError } from "./errors.ts";

/** How a body is reserved. */
export interface BodyOptions {
  /** Types that it should have; it is reserved without those that are taken, or not there. */
  readonly optional?: readonly AnyComponentClass[];
  /** Of components, as `search` takes it: `like("component_ref", "avatar/%")`. */
  readonly condition?: string;
  /** Milliseconds for which it is tried again; 0 for once. */
  readonly waitMs?: number;
}

/** A body that was reserved is not any more: a required part of it is lost, and the others were released. */
export interface BodyLoss {
  readonly engineId: string;
  /** The part that was lost; empty where the client was closed. */
  readonly componentRef: string;
  readonly error: Error;
}

/** Milliseconds for which is tried unless it is said otherwise. */
const WAIT = 10_000;
const FIRST = 100;
const LONGEST = 1000;

/** Most unanswered questions whether a component is free. */
const AT_ONCE = 64;

/** The wanted component types, by their URNs. */
interface Wanted {
  readonly required: ReadonlyMap<string, AnyComponentClass>;
  readonly optional: ReadonlyMap<string, AnyComponentClass>;
}

/** Lists and reserves the bodies of one client, and gives a body back when a part of it is lost. */
export class Bodies {
  readonly #client: Client;
  readonly #directory: EngineDirectory;
  readonly #bindings: Bindings;
  readonly #tell: (loss: BodyLoss) => void;
  readonly #random: () => number;
  readonly #reserved = new Map<string, Reservation>();
  /** Counts how often components came or went, as far as that can be known. */
  #generation = 0;

  constructor(
    client: Client,
    directory: EngineDirectory,
    bindings: Bindings,
    tell: (loss: BodyLoss) => void,
    { random = Math.random }: BackoffOptions = {},
  ) {
    this.#client = client;
    this.#directory = directory;
    this.#bindings = bindings;
    this.#tell = tell;
    this.#random = random;
    client.on("lost", (claim) => {
      if (claim.kind === "binding") this.#lose(claim.componentRef, claim.error);
    });
    client.on("profile_changed", () => (this.#generation += 1));
    client.on("state", ({ name }) => {
      this.#generation += 1;
      if (name !== "closed") return;
      const closed = new Error("the client is closed");
      for (const [ref, reservation] of this.#reserved) this.#loseAll(reservation, ref, closed);
    });
  }

  async all(): Promise<BodyInfo[]> {
    const bodies = await this.#read();
    const free = await this.#free(bodies);
    return bodies.map(({ engineId, components }) => {
      const parts = [...components].map(([componentRef, { componentType }]) => ({
        componentRef,
        componentType,
        free: free.get(componentRef) ?? null,
      }));
      const told = parts.map((part) => part.free);
      return {
        engineId,
        components: parts,
        free: told.includes(false) ? false : told.includes(null) ? null : true,
      };
    });
  }

  /** Returns all bodies, or those with components that meet a condition. */
  async #read(condition = ""): Promise<BodyProfile[]> {
    const isListed = condition === "" && this.#client.extensions?.includes(DIRECTORY);
    return isListed
      ? bodiesOf(await this.#directory.read())
      : bodiesIn(await this.#client.getProfile(condition));
  }

  /** Tells of each component whether no application holds it; of none where the gateway knows no leases. */
  async #free(bodies: readonly BodyProfile[]): Promise<ReadonlyMap<string, boolean | null>> {
    const free = new Map<string, boolean | null>();
    if (!this.#client.extensions?.includes("openrois.lease")) return free;
    for (const { components } of bodies)
      for (const [ref, part] of components) free.set(ref, part.function === "actuation" ? null : true);
    const leased = [...free].flatMap(([ref, told]) => (told === null ? [ref] : []));
    const ask = async (): Promise<void> => {
      for (let ref = leased.shift(); ref !== undefined; ref = leased.shift()) {
        // Where that fails it is gone meanwhile, or this application may not know.
        const lease = await this.#client.control.status(ref).catch(() => undefined);
        if (lease !== undefined) free.set(ref, (lease?.state ?? "FREE") === "FREE");
      }
    };
    await Promise.all(Array.from({ length: AT_ONCE }, ask));
    return free;
  }

  async reserve(
    types: readonly AnyComponentClass[],
    { optional = [], condition = "", waitMs = WAIT }: BodyOptions,
  ): Promise<Body> {
    const wanted = readWanted(types, optional);
    const deadline = performance.now() + waitMs;
    const backoff = new Backoff({ first: FIRST, max: LONGEST, random: this.#random });
    let bodies: BodyProfile[] = [];
    let readIn = -1;
    for (;;) {
      if (readIn !== this.#generation) {
        readIn = this.#generation;
        bodies = await this.#read(condition);
      }
      const refusals: RoISError[] = [];
      const said: string[] = [];
      for (const body of candidates(bodies, wanted)) {
        try {
          return await this.#reserve(body, wanted);
        } catch (error) {
          if (!(error instanceof RoISError)) throw error;
          refusals.push(error);
          said.push(`${body.engineId}: ${error.message}`);
        }
      }
      // Not every gateway notifies that components came or went.
      if (refusals.length === 0 || refusals.some(({ returnCode }) => returnCode === "UNSUPPORTED"))
        readIn = -1;
      const left = deadline - performance.now();
      if (left <= 0) throw failure(wanted, condition, bodies, said);
      await new Promise((resolve) => setTimeout(resolve, Math.min(backoff.next(), left)));
    }
  }

  /** Reserves one body, or nothing of it. */
  async #reserve(body: BodyProfile, wanted: Wanted): Promise<Body> {
    const reservation: Reservation = {
      engineId: body.engineId,
      optional: new Set(wanted.optional.keys()),
      bound: new Map(),
      complete: false,
      error: null,
    };
    try {
      await this.#bindEach(reservation, body, wanted.required, true);
      await this.#bindEach(reservation, body, wanted.optional, false);
      requireHeld(reservation);
    } catch (error) {
      await this.#giveBack(reservation);
      throw error;
    }
    reservation.complete = true;
    const types = new Map([...wanted.required, ...wanted.optional]);
    const components = new Map<string, object>();
    for (const [urn, ref] of reservation.bound) {
      const type = types.get(urn);
      if (type) components.set(urn, new type(this.#client, ref));
    }
    return new Body(reservation, components, () => this.#giveBack(reservation));
  }

  /** Binds the first component of each type that is to be had, in the sorted order of all references. */
  async #bindEach(
    reservation: Reservation,
    body: BodyProfile,
    types: ReadonlyMap<string, unknown>,
    required: boolean,
  ): Promise<void> {
    const found = [...types.keys()].flatMap((urn) => refsOf(body, urn).map((ref) => ({ ref, urn })));
    found.sort((one, other) => (one.ref < other.ref ? -1 : 1));
    for (const [place, { ref, urn }] of found.entries()) {
      if (reservation.bound.has(urn)) continue;
      try {
        await this.#bind(reservation, ref);
        reservation.bound.set(urn, ref);
      } catch (error) {
        const isLast = !found.slice(place + 1).some((other) => other.urn === urn);
        if (!(error instanceof RoISError) || (required && isLast)) throw error;
      }
    }
  }

  async #bind(reservation: Reservation, ref: string): Promise<void> {
    if (this.#reserved.has(ref))
      throw outOfResources(`(${ref})`, `${ref} is a part of another body of this application`);
    this.#reserved.set(ref, reservation);
    try {
      await this.#bindings.hold(this.#client.call, ref);
    } catch (error) {
      this.#reserved.delete(ref);
      throw error;
    }
    if (reservation.error === null) return;
    await this.#drop(ref);
    requireHeld(reservation);
  }

  /** Sends all releases at once, and resolves when they were answered. */
  async #giveBack({ bound }: Reservation): Promise<void> {
    const refs = [...bound.values()];
    bound.clear();
    await Promise.all(refs.map((ref) => this.#drop(ref)));
  }

  #drop(ref: string): Promise<void> {
    this.#reserved.delete(ref);
    return this.#bindings.drop(this.#client.call, ref);
  }

  #lose(ref: string, error: Error): void {
    const reservation = this.#reserved.get(ref);
    if (!reservation) return;
    const [urn] = [...reservation.bound].find(([, bound]) => bound === ref) ?? [];
    if (urn === undefined || !reservation.optional.has(urn)) return this.#loseAll(reservation, ref, error);
    reservation.bound.delete(urn);
    void this.#drop(ref);
  }

  #loseAll(reservation: Reservation, componentRef: string, error: Error): void {
    if (reservation.error !== null) return;
    reservation.error = error;
    void this.#giveBack(reservation);
    const { engineId, complete } = reservation;
    if (complete) this.#tell({ engineId, componentRef, error });
  }
}

/** Returns the bodies with all that is required, those that have more of what is optional first. */
function candidates(bodies: readonly BodyProfile[], { required, optional }: Wanted): BodyProfile[] {
  const extras = (body: BodyProfile): number =>
    [...optional.keys()].filter((urn) => refsOf(body, urn).length > 0).length;
  return bodies
    .filter((body) => [...required.keys()].every((urn) => refsOf(body, urn).length > 0))
    .sort((one, other) => extras(other) - extras(one));
}

function readWanted(types: readonly AnyComponentClass[], optional: readonly AnyComponentClass[]): Wanted {
  if (types.length === 0)
    throw new RangeError("name at least one component type that the body must have: body([Navigation])");
  const urns = [...types, ...optional].map(({ componentType }) => componentType);
  const twice = urns.find((urn, place) => urns.indexOf(urn) !== place);
  if (twice !== undefined)
    throw new RangeError(
      `${codeOf(twice)}: named twice, and a body is reserved with one component of a type`,
    );
  const byUrn = (kinds: readonly AnyComponentClass[]): Map<string, AnyComponentClass> =>
    new Map(kinds.map((kind) => [kind.componentType, kind]));
  return { required: byUrn(types), optional: byUrn(optional) };
}

function requireHeld({ error, engineId }: Reservation): void {
  if (error !== null) throw outOfResources(`(${engineId})`, `a part of it was lost again: ${error.message}`);
}

function outOfResources(asked: string, reason: string): RoISError {
  return new RoISError("OUT_OF_RESOURCES", "body", asked, reason);
}

function failure(
  { required }: Wanted,
  condition: string,
  bodies: readonly BodyProfile[],
  refusals: readonly string[],
): RoISError {
  const wanted = `body with ${[...required.keys()].map(codeOf).join(" and ")}${condition && ` where ${condition}`}`;
  if (refusals.length > 0) return outOfResources("", `no ${wanted} is free: ${refusals.join("; ")}`);
  const there = bodies.map((body) => `${body.engineId} (${abilities(body)})`).join("; ") || "none";
  return new RoISError("UNSUPPORTED", "body", "", `there is no ${wanted}; there are: ${there}`);
}
