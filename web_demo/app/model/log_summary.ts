/** A message of the log in one line of words: without ids and codes. Pure. */

import type { Json, Traffic } from "../../sdk/index.ts";
import { codeWords, componentWords, nameWords } from "./code_words.ts";
import { named, plainReason } from "./plain_words.ts";

const LONGEST = 120;
/** Members that say nothing to a reader of the line; they are in the message itself. */
const HIDDEN = new Set([
  "candidate",
  "epoch",
  "expire",
  "generation",
  "timestamp",
  "token",
  "ttl",
  "version",
]);
const ID = /(^|_)ids?$/;
const ONLY_COMPONENT = /^component_ref = '([^']+)'$/;

/** Texts by the names of their members. */
const TEXTS: ReadonlyMap<string, (text: string) => string> = new Map([
  ["component_ref", componentWords],
  ["condition", (text) => componentWords(ONLY_COMPONENT.exec(text)?.[1] ?? text)],
  ["error_type", codeWords],
  ["event_type", nameWords],
  ["holder", (text) => named(text, "another application")],
  ["query_type", nameWords],
  ["reason", plainReason],
  ["return_code", codeWords],
  ["sdp", () => "session description"],
  ["state", codeWords],
  ["status", codeWords],
  ["subject", (text) => named(text, "another application")],
]);

/** Returns the line. */
export function summarize({ kind, message }: Traffic): string {
  if (kind === "violation") return String(message);
  if (kind === "error") return String(member(member(message, "error"), "message"));
  return members(member(message, kind === "response" ? "result" : "params"));
}

/** Returns a member of an object; undefined where there is none. */
export function member(value: Json | undefined, name: string): Json | undefined {
  return typeof value === "object" && value !== null && !Array.isArray(value) ? value[name] : undefined;
}

function members(body: Json | undefined): string {
  if (typeof body !== "object" || body === null || Array.isArray(body)) return "";
  return Object.entries(body)
    .map(([name, value]) => memberWords(name, value))
    .filter((part) => part !== "")
    .join(", ");
}

function memberWords(name: string, value: Json): string {
  if (!value || HIDDEN.has(name) || (ID.test(name) && name !== "engine_id")) return "";
  if (name === "command_unit_list" && Array.isArray(value)) return value.map(commandWords).join(" → ");
  if (name === "lease") return members(value);
  if (Array.isArray(value)) return countWords(name, value.length);
  if (typeof value === "object") {
    return name.endsWith("s") ? countWords(name, Object.keys(value).length) : nameWords(name);
  }
  if (value === true) return nameWords(name);
  if (typeof value === "number") return numberWords(name, value);
  const text = (TEXTS.get(name) ?? plainReason)(value);
  return text.length > LONGEST ? `${text.slice(0, LONGEST - 1)}…` : text;
}

function countWords(name: string, count: number): string {
  if (count === 0) return "";
  const words = nameWords(name);
  return `${count} ${count === 1 ? words.replace(/s$/, "") : words}`;
}

function numberWords(name: string, value: number): string {
  if (name === "milliseconds") return `${value} ms`;
  const [, span] = /^(.+)_ms$/.exec(name) ?? [];
  return span === undefined ? `${nameWords(name)} ${value}` : `${nameWords(span)} ${value} ms`;
}

function commandWords(item: Json): string {
  const concurrent = member(item, "command_list");
  if (Array.isArray(concurrent)) return `(${concurrent.map(commandWords).join(" ∥ ")})`;
  return nameWords(String(member(item, "command_type")));
}
