/** The messages that the page remembers, and how one is put into a line. Pure. */

import type { Json, Traffic } from "../../sdk/index.ts";

export const MAX_ENTRIES = 500;
const EVENT = "rois.event.notify_event";
const QUERY = "rois.query.query";
/** How many lines back one is looked for that says the same. */
const LOOK_BACK = 12;
/** Questions whose answers are awaited; of an older one the answer is a line of its own. */
const MAX_ASKED = 64;
/** Characters of SDP that are shown; the message itself stays whole. */
const SDP_SHOWN = 120;
/** Ids are 96 or 128 random bits; their first digits tell them apart. */
const LONG_ID = /[0-9a-f]{24,32}/g;
const ID_SHOWN = 6;

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
  /** How many of its kind came, this one the last: what is told or asked all the time is one line. */
  readonly repeats: number;
  /** What those of its kind have in common; null for what is a line of its own each time. */
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

  /** Where the line is that says the same, with nothing but events and questions after it; -1 where there is none. */
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
    const params = field(message, "params");
    if (method === EVENT) return `event ${String(field(params, "subscribe_id"))}`;
    if (method !== QUERY) return null;
    const id = field(message, "id") ?? null;
    if (kind === "request") {
      const sort = `${String(field(params, "query_type"))} ${String(field(params, "condition"))}`;
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
  const code = field(field(message, "result"), "return_code");
  return typeof code === "string" && code !== "OK";
}

/** A secret is nothing to look at: every person who sees the page could use it. */
function withoutSecrets(traffic: Traffic): Traffic {
  if (!TELLS_SECRETS.has(traffic.method)) return traffic;
  const hide = (name: string, value: unknown): unknown => (SECRETS.has(name) && value !== null ? "…" : value);
  return { ...traffic, message: JSON.parse(JSON.stringify(traffic.message, hide)) as Json };
}

function summarize({ kind, message }: Traffic): string {
  if (kind === "violation") return String(message);
  if (kind === "error") {
    const error = field(message, "error");
    return `${String(field(error, "code"))} ${String(field(error, "message"))}`;
  }
  const body = field(message, kind === "response" ? "result" : "params");
  if (typeof body !== "object" || body === null || Array.isArray(body)) return "";
  return Object.entries(body)
    .map(([name, value]) => summarizeField(name, value))
    .filter((part) => part !== "")
    .join("  ");
}

function summarizeField(name: string, value: Json): string {
  if (name === "return_code") return String(value);
  if (name === "sdp") return `sdp ${String(value).length} characters`;
  if (value === "" || value === null) return "";
  if (name === "command_unit_list" && Array.isArray(value)) return value.map(commandType).join(" → ");
  if (Array.isArray(value)) return `${name}[${value.length}]`;
  if (typeof value === "object") return `${name}{${Object.keys(value).length}}`;
  if (name === "timestamp") return "";
  const text = String(value).replaceAll(LONG_ID, (id) => `${id.slice(0, ID_SHOWN)}…`);
  return text.length > 48 ? `${text.slice(0, 47)}…` : text;
}

function commandType(item: Json): string {
  const concurrent = field(item, "command_list");
  if (Array.isArray(concurrent)) return `(${concurrent.map(commandType).join(" ∥ ")})`;
  return String(field(item, "command_type"));
}

function field(value: Json | undefined, name: string): Json | undefined {
  return typeof value === "object" && value !== null && !Array.isArray(value) ? value[name] : undefined;
}
