/** Bodies that a person has stopped, so that programs wait until a person hands them back. */

import type { Client } from "../../sdk/index.ts";

/** A body that may act: its engine, and its actuators. */
export interface ActingBody {
  readonly engineId: string;
  readonly acting: readonly string[];
}

/** A body that is stopped, and by whom. */
export interface StoppedBody {
  readonly engineId: string;
  readonly by: string;
}

export class StoppedBodies {
  readonly #client: Client;
  readonly #onChange: () => void;
  /** By whom each body of the page is stopped; empty for no person. */
  readonly #by = new Map<string, string>();

  /** @param onChange is called when `first` may be another one */
  constructor(client: Client, onChange: () => void) {
    this.#client = client;
    this.#onChange = onChange;
    client.control.on("openrois.lease.stopped", ({ engine_id: engineId, by = "" }) =>
      this.#note(engineId, by),
    );
    // What was asked about is notified of for as long as the connection lasts.
    client.on("state", ({ name }) => {
      if (name !== "connected") this.#by.clear();
    });
  }

  /** @param bodies those that are shown large or in a card */
  setBodies(bodies: readonly ActingBody[]): void {
    const shown = new Set(bodies.map(({ engineId }) => engineId));
    for (const engineId of this.#by.keys()) if (!shown.has(engineId)) this.#by.delete(engineId);
    for (const { engineId, acting } of bodies) {
      const [componentRef] = acting;
      if (componentRef !== undefined && !this.#by.has(engineId)) void this.#ask(engineId, componentRef);
    }
    this.#onChange();
  }

  /** A body that is stopped, the one that is shown large first; null where none is. */
  get first(): StoppedBody | null {
    for (const [engineId, by] of this.#by) if (by !== "") return { engineId, by };
    return null;
  }

  /**
   * Hands a body back to programs.
   *
   * @throws RoISError (UNSUPPORTED: this page is no person's)
   */
  async handBack(engineId: string): Promise<void> {
    await this.#client.control.releaseStop(engineId);
    this.#note(engineId, "");
  }

  #note(engineId: string, by: string): void {
    if (!this.#by.has(engineId)) return;
    this.#by.set(engineId, by);
    this.#onChange();
  }

  async #ask(engineId: string, componentRef: string): Promise<void> {
    this.#by.set(engineId, "");
    const lease = await this.#client.control.status(componentRef).catch(() => null);
    const by = lease?.stopped_by ?? "";
    if (by !== "") this.#note(engineId, by);
  }
}
