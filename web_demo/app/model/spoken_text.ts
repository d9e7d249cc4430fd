/** A text being spoken, and its current word. Positions are Unicode code points. Pure. */

export interface Parts {
  readonly before: string;
  readonly word: string;
  readonly after: string;
}

/** The entities that XML itself knows. */
const ENTITIES: Readonly<Record<string, string>> = { amp: "&", lt: "<", gt: ">", quot: '"', apos: "'" };

/** Follows one text of several that the avatar may be saying, one after the other. */
export class SpokenText {
  readonly #characters: readonly string[];
  readonly #text: string;
  readonly #earlier: string;
  readonly #ssml: boolean;
  #id = "";
  #parts: Parts | null = null;

  /**
   * @param earlier the id of the speech before, whose last words may still be reported
   * @param ssml whether the text is an SSML document, of which only the contents are shown
   */
  constructor(text: string, earlier = "", ssml = false) {
    this.#text = text;
    this.#ssml = ssml;
    this.#characters = [...text];
    this.#earlier = earlier;
  }

  /** The id of its speech; empty until its first word. */
  get id(): string {
    return this.#id;
  }

  get parts(): Parts {
    return this.#parts ?? { before: "", word: "", after: this.#shown(this.#text) };
  }

  /** Sets the current word. Returns whether it belongs to this text. */
  wordHeard(id: string, position: number, length: number): boolean {
    if (id === this.#earlier || (this.#id !== "" && id !== this.#id)) return false;
    if (position < 0 || length < 0 || position + length > this.#characters.length) return false;
    this.#id = id;
    const part = (from: number, to?: number): string =>
      this.#shown(this.#characters.slice(from, to).join(""));
    this.#parts = {
      before: part(0, position),
      word: part(position, position + length),
      after: part(position + length),
    };
    return true;
  }

  /** A part of the text as people read it. Words begin and end outside of tags. */
  #shown(text: string): string {
    if (!this.#ssml) return text;
    return text
      .replace(/<[^>]*>/g, "")
      .replace(/&(\w+);/g, (entity, name: string) => ENTITIES[name] ?? entity);
  }
}
