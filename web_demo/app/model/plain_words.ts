/** What gateways and engines say, for a person: without references, codes and positions. Pure. */

/** What a gateway without authentication calls every application. */
const WITHOUT_TOKEN = "local";
/** What an application without a token is where visitors have tokens. */
const PROGRAM = "A program";
const NAMELESS = [PROGRAM, "Another visitor"];

/**
 * Returns how a holder is called.
 *
 * @param ranked whether this page's token names a rank that counts: then what shows no token is a program
 */
export function nameOfHolder(subject: string, ranked: boolean): string {
  return ranked && subject === WITHOUT_TOKEN ? PROGRAM : subject;
}

/** Names the subject of a token for a person; without tokens subjects have no names. */
export function named(subject: string, unknown = "Another visitor"): string {
  return subject === "" || subject === WITHOUT_TOKEN ? unknown : subject;
}

/** Returns a name as it stands within a sentence. */
export function amid(name: string): string {
  return NAMELESS.includes(name) ? `${name.charAt(0).toLowerCase()}${name.slice(1)}` : name;
}

/** A gateway says so of a component that another application holds by now. */
const HOLDER = /^\S+ is (?:now )?(?:held|bound|controlled) by (.+?)(?: now)?: /;
/** Random bits, with what stands before them: `avatar/0a1b…`, `command-0a1b…: `. */
const ID = /\S*[0-9a-f]{24,32}(?:…|: ?)?/g;
const CODE = /^[A-Z]+(_[A-Z]+)*$/;
/** A reference in a sentence; units such as km/h are none. */
const REFERENCE = /(^|[\s“"'(])[\w.-]+(?:\/[\w.-]+)*\/([A-Za-z]\w{2,})/g;

/** A gateway says so of a body that a person has stopped for programs. */
const STOPPED = /^\S+ was stopped by .+: programs wait until a person hands it back$/;

/** Whether a reason says that a person has stopped the body for programs. */
export function isStop(reason: string): boolean {
  return STOPPED.test(reason);
}

/** Returns what a reason says in plain words; empty for a return code and nothing else. */
export function plainReason(reason: string): string {
  const text = reason.trim().replace(/\.$/, "");
  if (CODE.test(text)) return "";
  const [, stopper] = /^everything was stopped by (.+)$/.exec(text) ?? [];
  if (stopper !== undefined) {
    const name = named(stopper, "");
    return name === "" ? "everything was stopped" : `everything was stopped by ${name}`;
  }
  const holder = HOLDER.exec(text)
    ?.slice(1)
    .find((name) => name !== undefined);
  if (holder !== undefined) return `${named(holder, "Another application")} has control now`;
  return text
    .replace(/ \(character \d+\)/g, "")
    .replace(ID, "")
    .replace(REFERENCE, (_, before: string, name: string) => before + name.replaceAll("_", " "));
}

/** Begins with a capital letter. */
export function sentence(text: string): string {
  return `${text.charAt(0).toUpperCase()}${text.slice(1)}`;
}
