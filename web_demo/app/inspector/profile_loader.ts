/** Loads the profiles of what is opened in the inspector: of components once for each version, of the engine that is shown. */

import { escapeLike, like, onlyComponent } from "../../sdk/index.ts";
import type {
  Client,
  ComponentEntry,
  EngineEntry,
  HRIComponentProfile,
  HRIEngineProfile,
} from "../../sdk/index.ts";
import type { Loaded } from "./entry_tree.ts";

/** Most profiles that are loaded for one view of the tree, and that are kept. */
const MOST = 1024;

export class ProfileLoader implements Loaded {
  readonly #client: Client;
  readonly #onLoaded: () => void;
  readonly #components = new Map<string, HRIComponentProfile>();
  /** The profile of the engine that is shown, and of which of its versions it is. */
  #engine: { readonly key: string; readonly id: string; readonly profile: HRIEngineProfile | null } | null =
    null;
  #wanted: ReadonlyMap<string, ComponentEntry> = new Map();
  #isLoading = false;

  /** @param onLoaded is called when more is loaded */
  constructor(client: Client, onLoaded: () => void) {
    this.#client = client;
    this.#onLoaded = onLoaded;
  }

  component(version: string): HRIComponentProfile | undefined {
    return this.#components.get(version);
  }

  engine(engineId: string): HRIEngineProfile | null {
    return this.#engine?.id === engineId ? this.#engine.profile : null;
  }

  /** Loads the profiles of these components, as far as they are not. */
  want(components: Iterable<ComponentEntry>): void {
    const wanted = new Map<string, ComponentEntry>();
    for (const component of components) {
      if (wanted.size === MOST) break;
      wanted.set(component.profile_version, component);
    }
    this.#wanted = wanted;
    if (!this.#isLoading) void this.#load();
  }

  /**
   * Loads the profile of an engine, without those of other engines.
   *
   * @param inner a component of an engine below it, by which an engine is found that owns none; empty without one
   */
  async wantEngine(entry: EngineEntry, inner: string): Promise<void> {
    const { engine_id: id, components = [] } = entry;
    const key = `${entry.version} ${inner}`;
    if (this.#engine?.id === id && this.#engine.key === key) return;
    const former = this.#engine?.id === id ? this.#engine.profile : null;
    this.#engine = { key, id, profile: former };
    const own = like("component_ref", `${escapeLike(id)}/%`);
    // A profile with a condition has the engines on the way to what meets it.
    const condition = components.length > 0 || inner === "" ? own : onlyComponent(inner);
    const answer = await this.#client.getProfile(condition).catch(() => null);
    if (this.#engine.key !== key || this.#engine.id !== id) return;
    if (answer === null) return void (this.#engine = null);
    this.#engine = { key, id, profile: engineIn(answer.profile, id) };
    this.#onLoaded();
  }

  async #load(): Promise<void> {
    this.#isLoading = true;
    const asked = new Set<ComponentEntry>();
    for (;;) {
      const missing = [...this.#wanted.values()].filter(
        (each) => !this.#components.has(each.profile_version) && !asked.has(each),
      );
      if (missing.length === 0) break;
      for (const each of missing) asked.add(each);
      // Without a connection nothing is loaded; the next list asks again.
      const profiles = await this.#client.profiles(missing).catch(() => null);
      if (profiles === null) break;
      for (const [version, profile] of profiles) this.#components.set(version, profile);
      this.#discard();
      if (profiles.size > 0) this.#onLoaded();
    }
    this.#isLoading = false;
  }

  #discard(): void {
    for (const version of this.#components.keys()) {
      if (this.#components.size <= MOST) return;
      if (!this.#wanted.has(version)) this.#components.delete(version);
    }
  }
}

function engineIn(engine: HRIEngineProfile | null, id: string): HRIEngineProfile | null {
  if (engine === null || engine.identifier.code === id) return engine;
  for (const below of engine.sub_profiles ?? []) {
    const found = engineIn(below, id);
    if (found) return found;
  }
  return null;
}
