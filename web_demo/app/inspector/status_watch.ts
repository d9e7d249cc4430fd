/** Polls the status of the components in view. */

import { onlyComponent } from "../../sdk/index.ts";
import type { Client, ComponentStatus } from "../../sdk/index.ts";

/** Milliseconds between two rounds of queries. */
const ROUND = 2000;
/** Rounds between two queries of components that are not selected. */
const EVERY = 3;
/** Most unanswered queries at a time: queries must not delay commands. */
const AT_ONCE = 4;

const STATUS_TYPE = "component_status";

export class StatusWatch {
  readonly #client: Client;
  readonly #onStatus: (ref: string, status: ComponentStatus | null) => void;
  /** The components that are asked, each with its query. */
  #watched: ReadonlyMap<string, string> = new Map();
  #close = "";
  /** Components with a running query, and whether to repeat it because of a change meanwhile. */
  readonly #asking = new Map<string, boolean>();
  #timer: ReturnType<typeof setTimeout> | undefined;
  /** Goes up when a round is the last one. */
  #round = 0;
  #rounds = 1;

  constructor(client: Client, onStatus: (ref: string, status: ComponentStatus | null) => void) {
    this.#client = client;
    this.#onStatus = onStatus;
  }

  /**
   * Polls these components from now on, and new ones at once.
   *
   * @param close the selected component, polled in every round; it need not be among them
   */
  watch(watched: ReadonlyMap<string, string>, close: string): void {
    this.#close = close;
    const fresh = [...watched.keys()].filter((ref) => !this.#watched.has(ref));
    this.#watched = watched;
    if (fresh.length > 0) void this.#askAll(fresh);
    if (watched.size === 0) this.#stop();
    else this.#timer ??= setTimeout(() => void this.#next(), ROUND);
  }

  /** Queries one component now, or again after its running query. */
  poke(ref: string): void {
    if (this.#asking.has(ref)) this.#asking.set(ref, true);
    else if (this.#watched.has(ref)) void this.#ask(ref);
  }

  #stop(): void {
    clearTimeout(this.#timer);
    this.#timer = undefined;
    this.#round += 1;
  }

  async #next(): Promise<void> {
    const round = this.#round;
    const all = this.#rounds++ % EVERY === 0;
    const refs = all ? [...this.#watched.keys()] : [this.#close];
    if (document.visibilityState === "visible") await this.#askAll(refs);
    if (round !== this.#round) return;
    this.#timer = setTimeout(() => void this.#next(), ROUND);
  }

  async #askAll(refs: string[]): Promise<void> {
    const waiting = [...refs];
    const line = async (): Promise<void> => {
      for (let ref = waiting.shift(); ref !== undefined; ref = waiting.shift()) await this.#ask(ref);
    };
    await Promise.all(Array.from({ length: AT_ONCE }, line));
  }

  async #ask(ref: string): Promise<void> {
    const query = this.#watched.get(ref);
    if (query === undefined || this.#asking.has(ref) || this.#client.state.name !== "connected") return;
    this.#asking.set(ref, false);
    try {
      const results = await this.#client.query(query, onlyComponent(ref));
      const status = results.find(({ data_type_ref }) => data_type_ref.toLowerCase() === STATUS_TYPE)?.value;
      this.#onStatus(ref, (status ?? null) as ComponentStatus | null);
    } catch {
      this.#onStatus(ref, null);
    }
    const again = this.#asking.get(ref);
    this.#asking.delete(ref);
    if (again) await this.#ask(ref);
  }
}
