/**
 * Which bodies the gateway has, and which one the page works with.
 *
 * A body is an engine that owns components (`bodiesIn` of the SDK): a robot or an avatar. The page offers those for which
 * it has a panel, and shows the others in the inspector alone. Each panel takes the references of the one body that it
 * works with, null for what that body cannot do, and knows no directory: a page with several bodies has a set of panels,
 * and a `BodyControl`, for each.
 */

import { bodiesIn, componentType } from "../../sdk/index.ts";
import type { Client, Profile } from "../../sdk/index.ts";

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
  sight: "Sight",
  enrolment: "Enrolment",
  hearing: "Hearing",
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
  speech,
}: PageBody): string[] {
  const moving = [teleoperation, navigation, move, follow, reaction].filter((ref) => ref !== null);
  // Of a body that only speaks, control is control of that.
  return moving.length > 0 || speech === null ? moving : [speech];
}

/** Returns the bodies that have something to be seen, heard or operated on the page, in the order of the profile. */
export function findBodies(profile: Profile): PageBody[] {
  const bodies: PageBody[] = [];
  for (const { engineId, components } of bodiesIn(profile)) {
    const refs = new Map<string, string>();
    for (const [ref, component] of components) {
      const type = componentType(component);
      if (!refs.has(type)) refs.set(type, ref);
    }
    const parts = Object.entries(TYPES).map(([name, type]) => [name, refs.get(type) ?? null] as const);
    const body = { engineId, ...Object.fromEntries(parts) } as PageBody;
    if (body.video !== null || body.audio !== null || movingParts(body).length > 0) bodies.push(body);
  }
  return bodies;
}

/** Reads the profile whenever it may have changed, and keeps the choice of a body. */
export class BodyDirectory {
  readonly #client: Client;
  readonly #onChange: () => void;
  readonly #preferred: string;
  #profile: Profile | null = null;
  #bodies: PageBody[] | null = null;
  #chosen: PageBody | null = null;
  #reading = false;
  #again = false;

  /** @param preferred the engine to choose if it is there; else it is the first that can be seen, or else the first */
  constructor(client: Client, onChange: () => void, preferred = "") {
    this.#client = client;
    this.#onChange = onChange;
    this.#preferred = preferred;
    client.on("profile_changed", () => void this.#read());
    client.on("state", ({ name }) => {
      if (name === "connected") void this.#read();
    });
  }

  /** The profile as it was read last; null until it was read for the first time. */
  get profile(): Profile | null {
    return this.#profile;
  }

  /** Null until the profile was read for the first time. */
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
        this.#profile = await this.#client.getProfile();
        this.#bodies = findBodies(this.#profile);
        this.choose(this.#chosen?.engineId ?? this.#first(this.#bodies));
      }
    } catch {
      // The connection ended, and the next one reads again.
    } finally {
      this.#reading = false;
    }
  }
}
