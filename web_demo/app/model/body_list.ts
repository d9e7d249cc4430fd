/** The bodies that are listed beside the large one: in pages where there are many, and found by their ids. Pure. */

import type { PageBody } from "./bodies.ts";

/** Bodies of a page; with more of them they are searched, too. */
export const PAGE = 50;

export class BodyList {
  #others: readonly PageBody[] = [];
  #found: readonly PageBody[] = [];
  #search = "";
  #pages = 1;

  /** @param chosen the engine of the body that is shown large, and is not listed */
  setBodies(bodies: readonly PageBody[], chosen: string): void {
    this.#others = bodies.filter(({ engineId }) => engineId !== chosen);
    // The field is gone with the need for it, and what was typed there with it.
    if (!this.isLong) this.#search = "";
    this.#find();
  }

  /** There are more than one page has. */
  get isLong(): boolean {
    return this.#others.length > PAGE;
  }

  /** How many there are in all. */
  get count(): number {
    return this.#others.length;
  }

  /** How many are found by what is searched. */
  get found(): number {
    return this.#found.length;
  }

  /** Those that are listed now. */
  get listed(): readonly PageBody[] {
    return this.#found.slice(0, this.#pages * PAGE);
  }

  /** How many come with the next page. */
  get more(): number {
    return Math.min(PAGE, this.#found.length - this.listed.length);
  }

  get search(): string {
    return this.#search;
  }

  /** Every word has to be in a body's id. */
  set search(search: string) {
    this.#search = search;
    this.#pages = 1;
    this.#find();
  }

  showMore(): void {
    this.#pages += 1;
  }

  #find(): void {
    const words = this.#search.toLowerCase().split(/\s+/).filter(Boolean);
    this.#found = this.#others.filter(({ engineId }) => {
      const id = engineId.toLowerCase();
      return words.every((word) => id.includes(word));
    });
  }
}
