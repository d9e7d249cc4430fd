/**
 * Which bodies the gateway has, and which one the page works with.
 *
 * A body is an engine that owns components (`bodiesIn` of the SDK): a robot or an avatar. The page offers those for which
 * it has a panel, and shows the others in the inspector alone. Each panel takes the references of the one body that it
 * works with, null for what that body cannot do, and knows no directory: a page with several bodies has a set of panels,
 * and a `BodyControl`, for each.
 */

import { bodiesIn, bodiesOf, codeOf, engineOf } from "../../sdk/index.ts";
import type { Client, EngineEntry, Profile } from "../../sdk/index.ts";

/** What is behind the gateway: the engines in short, or of a gateway of the base wire its whole profile. */
export type Listing = Profile | { readonly engines: ReadonlyMap<string, EngineEntry> };

/** The type of the component that each part of the page works with. */
const TYPES = {
  video: "VideoStreaming",
  audio: "AudioStreaming",
  speech: "SpeechSynthesis",
  reaction: "Reaction",
  system: "SystemInformation",
  gaze: "Gaze",
  viewpoint: "Viewpoint",
  operator: "Operator",
  teleoperation: "Teleoperation",
  surroundings: "Surroundings",
  navigation: "Navigation",
  move: "Move",
  follow: "Follow",
  progress: "SpeechProgress",
  dialogue: "Dialogue",
  sight: "Sight",
  enrolment: "Enrolment",
  hearing: "Hearing",
  visitors: "Visitors",
} as const;

type Part = keyof typeof TYPES;

/**
 * The components of a body that the page works with; of several of a type the first by reference, null where it has none.
 * References stay valid while the body is away: they do not change when it returns.
 */
export type PageBody = { readonly engineId: string } & { readonly [Name in Part]: string | null };

/** The components that move a body, the one that represents all of them first. */
export function movingParts({
  teleoperation,
  navigation,
  move,
  follow,
  reaction,
  gaze,
  speech,
}: PageBody): string[] {
  const moving = [teleoperation, navigation, move, follow, reaction, gaze].filter((ref) => ref !== null);
  // Of a body that only speaks, control is control of that.
  return moving.length > 0 || speech === null ? moving : [speech];
}

/** Returns the bodies that have something to be seen, heard or operated on the page, in the order of their ids. */
export function findBodies(listing: Listing): PageBody[] {
  const bodies: PageBody[] = [];
  const all = "engines" in listing ? bodiesOf(listing.engines) : bodiesIn(listing);
  for (const { engineId, components } of all) {
    const refs = new Map<string, string>();
    for (const [ref, { componentType }] of components) {
      const type = codeOf(componentType);
      if (!refs.has(type)) refs.set(type, ref);
    }
    const parts = Object.entries(TYPES).map(([name, type]) => [name, refs.get(type) ?? null] as const);
    const body = { engineId, ...Object.fromEntries(parts) } as PageBody;
    if (body.video !== null || body.audio !== null || movingParts(body).length > 0) bodies.push(body);
  }
  return bodies;
}

/** Reads what there is whenever it may have changed, and keeps the choice of a body. */
export class BodyDirectory {
  readonly #client: Client;
  readonly #onChange: () => void;
  readonly #preferred: string;
  #listing: Listing | null = null;
  /** Engines that have changed since they were read; null where any may have. */
  #changed: Set<string> | null = null;
  #bodies: readonly PageBody[] | null = null;
  #chosen: PageBody | null = null;
  #reading = false;
  #again = false;

  /** @param preferred the engine to choose if it is there; else it is the first that can be seen, or else the first */
  constructor(client: Client, onChange: () => void, preferred = "") {
    this.#client = client;
    this.#onChange = onChange;
    this.#preferred = preferred;
    client.on("profile_changed", ({ engineIds }) => {
      if (engineIds.size === 0) this.#changed = null;
      for (const engineId of engineIds) this.#changed?.add(engineId);
      void this.#read();
    });
    client.on("state", ({ name }) => {
      if (name !== "connected") return;
      this.#changed = null;
      void this.#read();
    });
  }

  /** What there was when it was read last; null until it was read for the first time. */
  get listing(): Listing | null {
    return this.#listing;
  }

  /** Null until they were read for the first time. One whose engines have not changed stays the same object. */
  get bodies(): readonly PageBody[] | null {
    return this.#bodies;
  }

  /** The body that is shown, also while it is away. */
  get chosen(): PageBody | null {
    return this.#chosen;
  }

  /** The chosen body is connected to the gateway. */
  get present(): boolean {
    return this.#bodies?.some(({ engineId }) => engineId === this.#chosen?.engineId) ?? false;
  }

  choose(engineId: string): void {
    this.#chosen = this.#bodies?.find((body) => body.engineId === engineId) ?? this.#chosen;
    this.#onChange();
  }

  #first(bodies: readonly PageBody[]): string {
    const preferred = bodies.find(({ engineId }) => engineId === this.#preferred);
    const first = preferred ?? bodies.find(({ video }) => video !== null) ?? bodies[0];
    return first?.engineId ?? "";
  }

  async #read(): Promise<void> {
    this.#again = true;
    if (this.#reading) return;
    this.#reading = true;
    try {
      while (this.#again) {
        this.#again = false;
        const changed = this.#changed;
        this.#changed = new Set();
        this.#listing = await this.#list();
        const bodies = this.#withSame(findBodies(this.#listing), changed);
        this.#bodies = bodies;
        this.choose(this.#chosen?.engineId ?? this.#first(bodies));
      }
    } catch {
      // The connection ended, and the next one reads again.
      this.#changed = null;
    } finally {
      this.#reading = false;
    }
  }

  async #list(): Promise<Listing> {
    const { extensions } = this.#client;
    return extensions?.includes("openrois.directory")
      ? { engines: await this.#client.engines() }
      : this.#client.getProfile();
  }

  /** Returns bodies, and those of them as they were that have not changed. */
  #withSame(bodies: readonly PageBody[], changed: ReadonlySet<string> | null): readonly PageBody[] {
    if (changed === null) return bodies;
    const former = new Map(this.#bodies?.map((body) => [body.engineId, body]));
    return bodies.map((body) => {
      const before = former.get(body.engineId);
      const refs = Object.values(body);
      const isSame = refs.every((ref) => ref === null || !changed.has(engineOf(ref)));
      return before && isSame && Object.values(before).join() === refs.join() ? before : body;
    });
  }
}
