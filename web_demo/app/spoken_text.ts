/** A text that is being said, and the word of it that is heard. Positions are Unicode code points. Pure. */

export interface Parts {
  readonly before: string;
  readonly word: string;
  readonly after: string;
}

/** Follows one text of several that the avatar may be saying, one after the other. */
export class SpokenText {
  readonly #characters: readonly string[];
  readonly #text: string;
  readonly #earlier: string;
  #id = "";
  #parts: Parts | null = null;

  /** @param earlier the id of the speech before, whose last words may still be told */
  constructor(text: string, earlier = "") {
    this.#text = text;
    this.#characters = [...text];
    this.#earlier = earlier;
  }

  /** The id of its speech; empty until its first word. */
  get id(): string {
    return this.#id;
  }

  get parts(): Parts {
    return this.#parts ?? { before: "", word: "", after: this.#text };
  }

  /** A word is heard. Returns whether it is of this text. */
  heard(id: string, position: number, length: number): boolean {
    if (id === this.#earlier || (this.#id !== "" && id !== this.#id)) return false;
    if (position < 0 || length < 0 || position + length > this.#characters.length) return false;
    this.#id = id;
    const part = (from: number, to?: number): string => this.#characters.slice(from, to).join("");
    this.#parts = {
      before: part(0, position),
      word: part(position, position + length),
      after: part(position + length),
    };
    return true;
  }
}
