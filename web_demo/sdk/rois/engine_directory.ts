/**
 * The engines behind the gateway as the client knows them: listed once, in pages, and then only those read that have
 * changed. For gateways that speak `openrois.directory`.
 */

import type {
  ComponentEntry,
  DirectoryChangedNotification,
  EngineEntry,
  HRIComponentProfile,
} from "./generated/types.ts";
import type { Call } from "./link.ts";

/** The name of the extension in `openrois.hello`. */
export const DIRECTORY = "openrois.directory";

/** Engines of one request, and components about whose profiles one asks. */
const MAX_ENGINES = 100;
const MAX_REFS = 256;

/** Profiles that are kept; equal ones are one. */
const MAX_PROFILES = 1024;

export class EngineDirectory {
  readonly #call: Call;
  readonly #entries = new Map<string, EngineEntry>();
  /** Engines that are others now than their entries say, or may be. */
  readonly #stale = new Set<string>();
  /** Profiles by their versions, those that were needed last behind the others. */
  readonly #profiles = new Map<string, HRIComponentProfile>();
  #isListed = false;
  /** Counts how often the whole list became invalid. */
  #lists = 0;
  #isAsking = false;
  /** The last of the requests, which are made one after another. */
  #turn: Promise<unknown> = Promise.resolve();

  constructor(call: Call) {
    this.#call = call;
  }

  /** Discards everything: there is another session, perhaps of another gateway. */
  reset(): void {
    this.#invalidate();
    this.#profiles.clear();
  }

  /** Notes which engines have changed. */
  noteChanges({ changed = [], gone = [], unnamed = 0 }: DirectoryChangedNotification): void {
    if (unnamed > 0) return this.#invalidate();
    for (const engineId of changed) this.#stale.add(engineId);
    for (const engineId of gone) {
      this.#entries.delete(engineId);
      // What is being read may be from before, and still have it.
      if (this.#isAsking) this.#stale.add(engineId);
      else this.#stale.delete(engineId);
    }
  }

  /** Returns the entries of all engines by their ids, as they are now; only what has changed is asked for. */
  read(): Promise<ReadonlyMap<string, EngineEntry>> {
    return this.#inTurn(async () => {
      // What has changed and waits to be notified comes before the reply: one reply at least is waited for.
      for (let isFresh = false; !isFresh || !this.#isListed || this.#stale.size > 0; isFresh = true)
        await (this.#isListed ? this.#readStale() : this.#list());
      return new Map(this.#entries);
    });
  }

  /**
   * Returns the profiles of components by their versions; each is asked for once for all components that share it. Those
   * of components that have gone meanwhile, or have another profile now, are absent.
   */
  profiles(components: Iterable<ComponentEntry>): Promise<ReadonlyMap<string, HRIComponentProfile>> {
    const refs = new Map([...components].map((each) => [each.profile_version, each.component_ref]));
    return this.#inTurn(async () => {
      const known = new Map<string, HRIComponentProfile>();
      const missing: string[] = [];
      for (const [version, ref] of refs) {
        const profile = this.#profiles.get(version);
        if (profile) known.set(version, profile);
        else missing.push(ref);
      }
      // Those that are needed now are dropped last.
      for (const [version, profile] of known) this.#keep(version, profile);
      await this.#load(missing, (version, profile) => {
        this.#keep(version, profile);
        if (refs.has(version)) known.set(version, profile);
      });
      return known;
    });
  }

  #invalidate(): void {
    this.#lists += 1;
    this.#isListed = false;
    this.#entries.clear();
    this.#stale.clear();
  }

  async #list(): Promise<void> {
    const lists = this.#lists;
    for (let after = ""; ;) {
      const { engines = [], next = "" } = await this.#ask(() =>
        this.#call("openrois.directory.list", { after, limit: MAX_ENGINES }),
      );
      if (lists !== this.#lists) return;
      // A change may have been notified before the reply to an older state was dealt with: it is read again.
      for (const entry of engines)
        if (!this.#stale.has(entry.engine_id)) this.#entries.set(entry.engine_id, entry);
      // One that does not go on would be asked for ever.
      if (next <= after) break;
      after = next;
    }
    this.#isListed = true;
  }

  async #readStale(): Promise<void> {
    const lists = this.#lists;
    const some = [...this.#stale].slice(0, MAX_ENGINES);
    for (const engineId of some) this.#stale.delete(engineId);
    try {
      const { engines = [], left = [] } = await this.#ask(() =>
        this.#call("openrois.directory.read", { engine_ids: some }),
      );
      if (lists !== this.#lists) return;
      const found = new Map(engines.map((entry) => [entry.engine_id, entry]));
      for (const engineId of left) this.#stale.add(engineId);
      for (const engineId of some) {
        if (this.#stale.has(engineId)) continue;
        const entry = found.get(engineId);
        if (entry) this.#entries.set(engineId, entry);
        else this.#entries.delete(engineId);
      }
    } catch (error) {
      if (lists === this.#lists) for (const engineId of some) this.#stale.add(engineId);
      throw error;
    }
  }

  async #load(
    refs: readonly string[],
    loaded: (version: string, profile: HRIComponentProfile) => void,
  ): Promise<void> {
    const waiting = [...refs];
    while (waiting.length > 0) {
      const some = waiting.splice(0, MAX_REFS);
      const { profiles = {}, left = [] } = await this.#ask(() =>
        this.#call("openrois.directory.profiles", { component_refs: some }),
      );
      for (const [version, profile] of Object.entries(profiles)) loaded(version, profile);
      // Where nothing found room, more would be asked for ever.
      if (left.length < some.length) waiting.unshift(...left);
    }
  }

  #keep(version: string, profile: HRIComponentProfile): void {
    this.#profiles.delete(version);
    this.#profiles.set(version, profile);
    for (const oldest of this.#profiles.keys()) {
      if (this.#profiles.size <= MAX_PROFILES) return;
      this.#profiles.delete(oldest);
    }
  }

  async #ask<T>(request: () => Promise<T>): Promise<T> {
    this.#isAsking = true;
    try {
      return await request();
    } finally {
      this.#isAsking = false;
    }
  }

  #inTurn<T>(step: () => Promise<T>): Promise<T> {
    const result = this.#turn.then(step);
    this.#turn = result.catch(() => undefined);
    return result;
  }
}
