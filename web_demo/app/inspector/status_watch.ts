/** How the components are that are in sight, asked again and again. */

import { onlyComponent } from "../../sdk/index.ts";
import type { Client, ComponentStatus } from "../../sdk/index.ts";

/** Milliseconds between two rounds of questions. */
const ROUND = 3000;
/** How many questions are unanswered at a time: whoever looks must not be in the way of whoever acts. */
const AT_ONCE = 4;

const STATUS_TYPE = "component_status";

export class StatusWatch {
  readonly #client: Client;
  readonly #onStatus: (ref: string, status: ComponentStatus | null) => void;
  /** The components that are asked, each with its query. */
  #watched: ReadonlyMap<string, string> = new Map();
  #asking = new Set<string>();
  #timer: ReturnType<typeof setTimeout> | undefined;
  #round = 0;

  constructor(client: Client, onStatus: (ref: string, status: ComponentStatus | null) => void) {
    this.#client = client;
    this.#onStatus = onStatus;
  }

  /** Asks these from now on, and those that are new among them at once. */
  watch(watched: ReadonlyMap<string, string>): void {
    const fresh = [...watched.keys()].filter((ref) => !this.#watched.has(ref));
    this.#watched = watched;
    if (fresh.length > 0) void this.#askAll(fresh);
    if (watched.size === 0) this.#stop();
    else this.#timer ??= setTimeout(() => void this.#next(), ROUND);
  }

  /** Asks one of them now. */
  poke(ref: string): void {
    if (this.#watched.has(ref)) void this.#ask(ref);
  }

  #stop(): void {
    clearTimeout(this.#timer);
    this.#timer = undefined;
    this.#round += 1;
  }

  async #next(): Promise<void> {
    const round = this.#round;
    if (document.visibilityState === "visible") await this.#askAll([...this.#watched.keys()]);
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
    this.#asking.add(ref);
    try {
      const results = await this.#client.query(query, onlyComponent(ref));
      const status = results.find(({ data_type_ref }) => data_type_ref.toLowerCase() === STATUS_TYPE)?.value;
      this.#onStatus(ref, (status ?? null) as ComponentStatus | null);
    } catch {
      this.#onStatus(ref, null);
    } finally {
      this.#asking.delete(ref);
    }
  }
}
