/** Captions: the one or two lines of the avatar's speech with the current word. Pure. */

import { SpokenText } from "./spoken_text.ts";
import type { Parts } from "./spoken_text.ts";

/** Characters that are shown at once, at most; one word may be longer. */
const LONGEST = 84;
/** Words shown of a speech whose beginning was missed. */
const LAST_WORDS = 8;

/** Follows one speech. */
export class Caption {
  readonly id: string;
  readonly #text: SpokenText | null;
  readonly #words: string[] = [];

  /** @param text what is said, or an SSML document; null where its beginning was missed */
  constructor(id: string, text: string | null, ssml = false) {
    this.id = id;
    this.#text = text === null ? null : new SpokenText(text, "", ssml);
  }

  wordHeard(word: string, position: number, length: number): void {
    if (this.#text) return void this.#text.wordHeard(this.id, position, length);
    this.#words.push(word);
    if (this.#words.length > LAST_WORDS) this.#words.shift();
  }

  /** The part that is to be read now. */
  get shown(): Parts {
    if (!this.#text) {
      const before = this.#words.slice(0, -1).map((word) => `${word} `);
      return { before: before.join(""), word: this.#words.at(-1) ?? "", after: "" };
    }
    const { before, word, after } = this.#text.parts;
    const all = `${before}${word}${after}`;
    const at = before.length;
    const [start, end] = piece(all, at);
    return {
      before: all.slice(start, at),
      word,
      after: all.slice(at + word.length, Math.max(end, at + word.length)),
    };
  }
}

/** Where the piece of a text that has a place begins and ends: whole sentences where they fit, else whole words. */
function piece(text: string, at: number): readonly [number, number] {
  let start = 0;
  for (;;) {
    const end = endOfPiece(text, start);
    if (at < end || end >= text.length) return [start, end];
    start = end;
  }
}

function endOfPiece(text: string, start: number): number {
  if (text.length - start <= LONGEST) return text.length;
  const window = text.slice(start, start + LONGEST);
  const sentence = Math.max(
    ...[...window.matchAll(/[.!?…]\s+|[。！？]/g)].map(({ 0: sign, index }) => index + sign.length),
    0,
  );
  if (sentence > 0) return start + sentence;
  const space = window.search(/\s\S*$/);
  if (space > 0) return start + space + 1;
  const end = start + LONGEST;
  // A character of two code units stays whole.
  return /[\uDC00-\uDFFF]/.test(text.charAt(end)) ? end - 1 : end;
}
