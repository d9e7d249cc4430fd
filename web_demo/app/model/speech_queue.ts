/** Texts that wait to be spoken, one after the other. Pure. */

export interface Utterance {
  readonly id: number;
  readonly text: string;
  /** Whether the text is an SSML document. */
  readonly ssml: boolean;
  /** A BCP 47 tag; empty for the voice's own language. */
  readonly language: string;
}

/** What `SpeechQueue.add` refuses, as a sentence with its remedy. */
export class QueueRefusal extends Error {}

/** Most characters (code points) of one utterance: what `SpeechSynthesis` takes. */
export const LONGEST = 4000;
/** Most utterances that wait. */
export const MOST = 10;

const SSML = /^\s*(?:<\?xml[^>]*>\s*)?<speak[\s>]/i;
/** Ends of sentences, and where there is none, of words. */
const ENDS = [/[.!?…。！？]["'”’)]*\s*(?=\S)/gu, /\s+(?=\S)/gu];

export class SpeechQueue {
  #waiting: Utterance[] = [];
  #lastId = 0;

  get waiting(): readonly Utterance[] {
    return this.#waiting;
  }

  /**
   * Adds a text; one that is too long for an utterance becomes several, cut at the ends of sentences.
   *
   * @throws QueueRefusal when it does not fit; nothing of it is added then
   */
  add(text: string, language: string): void {
    const ssml = isSsml(text);
    const parts = ssml ? [text] : split(text);
    const count = [...text].length;
    if (ssml && count > LONGEST)
      throw new QueueRefusal(
        `This SSML has ${number(count)} characters and at most ${number(LONGEST)} are spoken: shorten it.`,
      );
    if (this.#waiting.length + parts.length > MOST)
      throw new QueueRefusal(
        parts.length > 1
          ? `This text has ${number(count)} characters, more than can wait to be spoken: shorten it.`
          : `${MOST} texts wait already: let one be spoken or remove one first.`,
      );
    for (const part of parts) this.#waiting.push({ id: ++this.#lastId, text: part, ssml, language });
  }

  /** Takes the next one out; null when none waits. */
  next(): Utterance | null {
    return this.#waiting.shift() ?? null;
  }

  /** Puts an utterance back as the next one. */
  putBack(utterance: Utterance): void {
    this.#waiting.unshift(utterance);
  }

  remove(id: number): void {
    this.#waiting = this.#waiting.filter((each) => each.id !== id);
  }

  clear(): void {
    this.#waiting = [];
  }
}

/** Whether a text is an SSML document, to be spoken without its tags. */
export function isSsml(text: string): boolean {
  return SSML.test(text);
}

/** Cuts a text into parts of at most `longest` code points, at ends of sentences where there are any. */
export function split(text: string, longest = LONGEST): string[] {
  const parts: string[] = [];
  let rest = [...text.trim()];
  while (rest.length > longest) {
    // The next character shows whether the part ends there.
    const ahead = rest.slice(0, longest + 1).join("");
    const end = endOf(ahead);
    const part = end > 0 ? [...ahead.slice(0, end)] : rest.slice(0, longest);
    parts.push(part.join("").trim());
    rest = [...rest.slice(part.length).join("").trim()];
  }
  return rest.length > 0 ? [...parts, rest.join("")] : parts;
}

/** Where the last sentence, or else the last word, of a text ends; 0 where neither does. */
function endOf(text: string): number {
  for (const ends of ENDS) {
    const last = [...text.matchAll(ends)].at(-1);
    if (last) return last.index + last[0].length;
  }
  return 0;
}

function number(count: number): string {
  return count.toLocaleString("en");
}
