/** The messages that the page remembers. Pure. */

import type { Json, Traffic } from "../../sdk/index.ts";
import { member, summarize } from "./log_summary.ts";

export const MAX_ENTRIES = 500;
const EVENT = "rois.event.notify_event";
const QUERY = "rois.query.query";
/** Lines back in which a message of the same sort is looked for. */
const LOOK_BACK = 12;
/** Most queries whose responses are matched; the response to an older one gets its own line. */
const MAX_ASKED = 64;
/** Characters of SDP that are shown; the message itself stays whole. */
const SDP_SHOWN = 120;

const SECRETS = new Set(["token", "credential"]);
const TELLS_SECRETS = new Set([
  "openrois.auth.refresh",
  "openrois.lease.token",
  "openrois.lease.resume",
  "signaling.ice_servers",
]);

export interface LogEntry {
  readonly number: number;
  readonly traffic: Traffic;
  /** One line: what matters about the message. */
  readonly summary: string;
  /** In small letters, for the filter. */
  readonly text: string;
  readonly failed: boolean;
  /** Number of messages of this sort, this one the last: frequent events and queries share one line. */
  readonly repeats: number;
  /** Identifies messages that share a line; null for a message with its own line. */
  readonly sort: string | null;
}

/** Remembers the newest messages. While it is paused, what is shown does not change. */
export class LogModel {
  readonly #entries: LogEntry[] = [];
  /** The sorts of the questions that are not answered, by their ids. */
  readonly #asked = new Map<Json, string>();
  #number = 0;

  get entries(): readonly LogEntry[] {
    return this.#entries;
  }

  add(heard: Traffic): LogEntry {
    const traffic = withoutSecrets(heard);
    const sort = this.#sort(traffic);
    const index = sort === null ? -1 : this.#again(sort);
    const before = this.#entries[index];
    const entry = {
      number: before ? before.number : this.#number++,
      repeats: (before?.repeats ?? 0) + 1,
      sort,
      traffic,
      summary: summarize(traffic),
      text: `${traffic.direction} ${traffic.kind} ${traffic.method} ${JSON.stringify(traffic.message)}`.toLowerCase(),
      failed: isFailure(traffic),
    };
    if (before) this.#entries[index] = entry;
    else this.#entries.push(entry);
    if (this.#entries.length > MAX_ENTRIES) this.#entries.shift();
    return entry;
  }

  clear(): void {
    this.#entries.length = 0;
  }

  /** Returns the index of the line of this sort with only events and queries after it; -1 where there is none. */
  #again(sort: string): number {
    const end = this.#entries.length - 1;
    for (let index = end; index >= Math.max(0, end - LOOK_BACK); index--) {
      const other = this.#entries[index]?.sort ?? null;
      if (other === null || other === sort) return other === null ? -1 : index;
    }
    return -1;
  }

  #sort(traffic: Traffic): string | null {
    const { kind, method, message } = traffic;
    const params = member(message, "params");
    if (method === EVENT) return `event ${String(member(params, "subscribe_id"))}`;
    if (method !== QUERY) return null;
    const id = member(message, "id") ?? null;
    if (kind === "request") {
      const sort = `${String(member(params, "query_type"))} ${String(member(params, "condition"))}`;
      this.#asked.set(id, sort);
      for (const first of this.#asked.keys()) if (this.#asked.size > MAX_ASKED) this.#asked.delete(first);
      return `question ${sort}`;
    }
    const sort = this.#asked.get(id);
    this.#asked.delete(id);
    return sort === undefined || isFailure(traffic) ? null : `answer ${sort}`;
  }
}

/** Every word of the filter has to be somewhere in the message. */
export function matches(entry: LogEntry, filter: string): boolean {
  const words = filter.toLowerCase().split(/\s+/);
  return words.every((word) => entry.text.includes(word));
}

/** Returns the message as indented JSON in which SDP is shortened. */
export function pretty(message: Json): string {
  return JSON.stringify(
    message,
    (name, value: unknown) => (name === "sdp" && typeof value === "string" ? shortened(value) : value),
    2,
  );
}

function shortened(sdp: string): string {
  if (sdp.length <= SDP_SHOWN) return sdp;
  const sections = sdp.match(/^m=\w+/gm)?.map((section) => section.slice(2)) ?? [];
  return `${sdp.slice(0, SDP_SHOWN)} … (${sdp.length} characters; ${sections.join(", ")})`;
}

function isFailure({ kind, message }: Traffic): boolean {
  if (kind === "error" || kind === "violation") return true;
  const code = member(member(message, "result"), "return_code");
  return typeof code === "string" && code !== "OK";
}

/** Replaces secrets, which the page must not show. */
function withoutSecrets(traffic: Traffic): Traffic {
  if (!TELLS_SECRETS.has(traffic.method)) return traffic;
  const hide = (name: string, value: unknown): unknown => (SECRETS.has(name) && value !== null ? "…" : value);
  return { ...traffic, message: JSON.parse(JSON.stringify(traffic.message, hide)) as Json };
}
