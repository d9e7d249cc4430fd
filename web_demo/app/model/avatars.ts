/** Which avatars there are, and which one the page shows. */

import { componentsByEngine } from "../../sdk/index.ts";
import type { Client, Profile } from "../../sdk/index.ts";

/** An engine that can be seen. References stay valid while it is away: they do not change when it returns. */
export interface Avatar {
  readonly engineId: string;
  readonly video: string;
  readonly audio: string | null;
  readonly speech: string | null;
  readonly reaction: string | null;
  readonly system: string | null;
  readonly gaze: string | null;
  readonly viewpoint: string | null;
  readonly operator: string | null;
  readonly teleoperation: string | null;
  readonly surroundings: string | null;
  readonly navigation: string | null;
  readonly move: string | null;
  readonly follow: string | null;
  readonly progress: string | null;
  readonly sight: string | null;
  readonly enrolment: string | null;
  readonly hearing: string | null;
}

/** The components that move an avatar's body, the one that represents all of them first. */
export function bodyOf({ teleoperation, navigation, move, follow, reaction, speech }: Avatar): string[] {
  const moving = [teleoperation, navigation, move, follow, reaction].filter((ref) => ref !== null);
  // Of an avatar that only speaks, control is control of that.
  return moving.length > 0 || speech === null ? moving : [speech];
}

export function findAvatars(profile: Profile): Avatar[] {
  const avatars: Avatar[] = [];
  for (const [engineId, components] of componentsByEngine(profile)) {
    const of = (type: string): string | null => components.get(type) ?? null;
    const video = of("VideoStreaming");
    if (video === null) continue;
    avatars.push({
      engineId,
      video,
      audio: of("AudioStreaming"),
      speech: of("SpeechSynthesis"),
      reaction: of("Reaction"),
      system: of("SystemInformation"),
      gaze: of("Gaze"),
      viewpoint: of("Viewpoint"),
      operator: of("Operator"),
      teleoperation: of("Teleoperation"),
      surroundings: of("Surroundings"),
      navigation: of("Navigation"),
      move: of("Move"),
      follow: of("Follow"),
      progress: of("SpeechProgress"),
      sight: of("Sight"),
      enrolment: of("Enrolment"),
      hearing: of("Hearing"),
    });
  }
  return avatars;
}

/** Reads the profile whenever it may have changed. */
export class AvatarDirectory {
  readonly #client: Client;
  readonly #onChange: () => void;
  readonly #preferred: string;
  #profile: Profile | null = null;
  #avatars: Avatar[] | null = null;
  #chosen: Avatar | null = null;
  #reading = false;
  #again = false;

  /** @param preferred the engine to choose if it is there; else it is the first */
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
  get avatars(): readonly Avatar[] | null {
    return this.#avatars;
  }

  /** The avatar that is shown, also while it is away. */
  get chosen(): Avatar | null {
    return this.#chosen;
  }

  /** The chosen avatar is connected to the gateway. */
  get present(): boolean {
    return this.#avatars?.some(({ engineId }) => engineId === this.#chosen?.engineId) ?? false;
  }

  choose(engineId: string): void {
    this.#chosen = this.#avatars?.find((avatar) => avatar.engineId === engineId) ?? this.#chosen;
    this.#onChange();
  }

  #first(avatars: readonly Avatar[]): string {
    const preferred = avatars.find(({ engineId }) => engineId === this.#preferred);
    return (preferred ?? avatars[0])?.engineId ?? "";
  }

  async #read(): Promise<void> {
    this.#again = true;
    if (this.#reading) return;
    this.#reading = true;
    try {
      while (this.#again) {
        this.#again = false;
        this.#profile = await this.#client.getProfile();
        this.#avatars = findAvatars(this.#profile);
        this.choose(this.#chosen?.engineId ?? this.#first(this.#avatars));
      }
    } catch {
      // The connection ended, and the next one reads again.
    } finally {
      this.#reading = false;
    }
  }
}
