/** The components that this session has bound, read from the messages of all parts of the page. Pure. */

import type { Json, Traffic } from "../../sdk/index.ts";

const BIND = "rois.command.bind";
const BIND_ANY = "rois.command.bind_any";
const RELEASE = "rois.command.release";
/** Tells that a component came or went with its part, or by another application. */
const CHANGED = "openrois.lease.changed";

/** Most unanswered requests that are remembered; a session has fewer. */
const MOST_ASKED = 256;

export class BoundComponents {
  readonly #held = new Set<string>();
  readonly #asked = new Map<Json, string>();

  has(componentRef: string): boolean {
    return this.#held.has(componentRef);
  }

  /** Reads one message; returns whether it changed what is bound. */
  observe({ kind, method, message }: Traffic): boolean {
    if (method === CHANGED && kind === "notification") {
      const params = member(message, "params");
      return this.#set(String(member(params, "component_ref")), member(params, "state") === "MINE");
    }
    if (method !== BIND && method !== BIND_ANY && method !== RELEASE) return false;
    const id = member(message, "id") ?? null;
    if (kind === "request") {
      this.#asked.set(id, String(member(member(message, "params"), "component_ref") ?? ""));
      for (const [oldest] of this.#asked) {
        if (this.#asked.size <= MOST_ASKED) break;
        this.#asked.delete(oldest);
      }
      return false;
    }
    const asked = this.#asked.get(id) ?? "";
    this.#asked.delete(id);
    const result = member(message, "result");
    if (kind !== "response" || member(result, "return_code") !== "OK") return false;
    const ref = method === BIND_ANY ? String(member(result, "component_ref")) : asked;
    return this.#set(ref, method !== RELEASE);
  }

  #set(ref: string, isHeld: boolean): boolean {
    const before = this.#held.has(ref);
    if (isHeld) this.#held.add(ref);
    else this.#held.delete(ref);
    return before !== isHeld;
  }

  /** Removes components that have gone, or whose session has. */
  lose(gone: (componentRef: string) => boolean): void {
    for (const ref of this.#held) if (gone(ref)) this.#held.delete(ref);
  }
}

function member(value: Json | undefined, name: string): Json | undefined {
  return typeof value === "object" && value !== null && !Array.isArray(value) ? value[name] : undefined;
}
