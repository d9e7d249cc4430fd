/** Which of the bodies that are listed are free: asked for those alone, and then told by the gateway. */

import type { Client, LeaseStatus } from "../../sdk/index.ts";
import { movingParts } from "./bodies.ts";
import type { PageBody } from "./bodies.ts";
import { named, nameOfHolder } from "./plain_words.ts";

/** Most unanswered questions at a time: they must not delay commands. */
const AT_ONCE = 8;

/** In short which application has control of a body. */
export type Holding = { readonly kind: "free" | "mine" } | { readonly kind: "held"; readonly holder: string };

export class BodyHolders {
  readonly #client: Client;
  readonly #onChange: () => void;
  /** Whether this page's token names a rank that counts: then what shows no token is a program. */
  ranked = false;
  #watched: ReadonlySet<PageBody> = new Set();
  #refs: ReadonlySet<string> = new Set();
  readonly #leases = new Map<string, LeaseStatus>();
  #waiting: string[] = [];
  #asking = 0;

  /** @param onChange is called when what `of` says may have changed */
  constructor(client: Client, onChange: () => void) {
    this.#client = client;
    this.#onChange = onChange;
    client.control.on("openrois.lease.changed", ({ reason: _, ...lease }) => {
      const { component_ref: ref = "" } = lease;
      if (!this.#refs.has(ref)) return;
      this.#leases.set(ref, lease);
      onChange();
    });
  }

  /** Asks about these bodies from now on; about one that is the same object as before not again. */
  watch(bodies: readonly PageBody[]): void {
    const fresh = bodies.filter((body) => !this.#watched.has(body)).flatMap(operatedPart);
    this.#watched = new Set(bodies);
    this.#refs = new Set(bodies.flatMap(operatedPart));
    for (const ref of this.#leases.keys()) if (!this.#refs.has(ref)) this.#leases.delete(ref);
    if (!this.#client.extensions?.includes("openrois.lease")) return;
    this.#waiting = [...new Set([...this.#waiting, ...fresh])].filter((ref) => this.#refs.has(ref));
    while (this.#asking < AT_ONCE && this.#waiting.length > 0) void this.#ask();
  }

  /** Returns who has control of a body; null where that is not known, or nothing of it can be controlled. */
  of(body: PageBody): Holding | null {
    const [lease] = operatedPart(body).flatMap((ref) => this.#leases.get(ref) ?? []);
    if (!lease) return null;
    if (lease.state === "MINE") return { kind: "mine" };
    if (lease.state === "FREE") return { kind: "free" };
    return { kind: "held", holder: named(nameOfHolder(lease.holder ?? "", this.ranked)) };
  }

  async #ask(): Promise<void> {
    this.#asking += 1;
    for (let ref = this.#waiting.shift(); ref !== undefined; ref = this.#waiting.shift()) {
      const lease = await this.#client.control.status(ref).catch(() => null);
      if (lease === null || !this.#refs.has(ref)) continue;
      this.#leases.set(ref, lease);
      this.#onChange();
    }
    this.#asking -= 1;
  }
}

/** The component that represents all that move a body, if there is one. */
function operatedPart(body: PageBody): string[] {
  return movingParts(body).slice(0, 1);
}
