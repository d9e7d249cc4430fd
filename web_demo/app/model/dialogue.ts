/** What was said to a body and by it, with the one that said it. Pure. */

import type { SpeechBegan, SpeechEnded } from "./own_components.ts";
import { SpokenText } from "./spoken_text.ts";

/** So many lines are kept. */
export const MOST_LINES = 50;
/** Characters of a line that are shown. */
const LONGEST = 500;

export interface DialogueLine {
  readonly kind: "heard" | "said";
  readonly by: string;
  readonly text: string;
  /** What was heard of it before it was interrupted; null where it was not. */
  readonly cut: string | null;
}

interface Speech {
  readonly began: SpeechBegan;
  readonly by: string;
}

export class DialogueLines {
  #lines: readonly DialogueLine[] = [];
  /** The last speech that began, and its line; null before the first and when it has ended. */
  #speech: (Speech & { readonly line: DialogueLine }) | null = null;

  get all(): readonly DialogueLine[] {
    return this.#lines;
  }

  clear(): void {
    this.#lines = [];
    this.#speech = null;
  }

  heard(text: string, by: string): void {
    if (text.trim() !== "") this.#add({ kind: "heard", by, text: short(text), cut: null });
  }

  began(began: SpeechBegan, by: string): void {
    const text = new SpokenText(began.text, "", began.is_ssml).parts.after.trim();
    const line: DialogueLine = { kind: "said", by, text: short(text), cut: null };
    this.#speech = { began, by, line };
    if (text !== "") this.#add(line);
  }

  /** Marks a speech that was interrupted with what was heard of it. */
  ended({ speech_id, status, word, position }: SpeechEnded): void {
    const speech = this.#speech;
    if (speech?.began.speech_id !== speech_id) return;
    this.#speech = null;
    if (status !== "ABORT") return;
    const spoken = new SpokenText(speech.began.text, "", speech.began.is_ssml);
    const length = [...(word ?? "")].length;
    const isKnown = position !== undefined && spoken.wordHeard(speech_id, position, length);
    const { before, word: last } = spoken.parts;
    const cut = isKnown ? short(`${before}${last}`.trim()) : "";
    this.#lines = this.#lines.map((line) => (line === speech.line ? { ...line, cut } : line));
  }

  #add(line: DialogueLine): void {
    this.#lines = [...this.#lines, line].slice(-MOST_LINES);
  }
}

function short(text: string): string {
  const characters = [...text];
  return characters.length > LONGEST ? `${characters.slice(0, LONGEST - 1).join("")}…` : text;
}

/** Names a visitor: this page, another one, or one that is not told apart. */
export function visitorName(visitorRef: string | undefined, own: string): string {
  if (visitorRef === undefined || visitorRef === "") return "A visitor";
  if (visitorRef === own) return "You";
  return `Visitor ${visitorRef.slice(visitorRef.lastIndexOf("/") + 1).slice(0, 6)}`;
}
