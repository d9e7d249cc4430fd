/** What gateways and engines say, for a person: without references, codes and positions. Pure. */

import { named } from "./names.ts";

const CODE = /^[A-Z]+(_[A-Z]+)*$/;
/** A reference in a sentence; units such as km/h are none. */
const REFERENCE = /(^|[\s“"'(])[\w.-]+(?:\/[\w.-]+)*\/([A-Za-z]\w{2,})/g;

/** Returns what a reason says in plain words; empty for a return code and nothing else. */
export function plainReason(reason: string): string {
  const text = reason.trim().replace(/\.$/, "");
  if (CODE.test(text)) return "";
  const [, stopper] = /^everything was stopped by (.+)$/.exec(text) ?? [];
  if (stopper !== undefined) {
    const name = named(stopper, "");
    return name === "" ? "everything was stopped" : `everything was stopped by ${name}`;
  }
  const [, holder] = /^\S+ is (.+)'s now: /.exec(text) ?? [];
  if (holder !== undefined) return `${named(holder)} has control now`;
  return text
    .replace(/ \(character \d+\)/g, "")
    .replace(REFERENCE, (_, before: string, name: string) => before + name.replaceAll("_", " "));
}

/** Begins with a capital letter. */
export function sentence(text: string): string {
  return `${text.charAt(0).toUpperCase()}${text.slice(1)}`;
}
