/** Many bodies in short: searched by their ids, a page at a time, each with who has control of it. */

import type { Client } from "../../sdk/index.ts";
import { byTestId, make, setText } from "../dom/elements.ts";
import type { PageBody } from "../model/bodies.ts";
import { BodyHolders } from "../model/body_holders.ts";
import type { Holding } from "../model/body_holders.ts";
import type { BodyList } from "../model/body_list.ts";

interface Row {
  readonly element: HTMLElement;
  readonly status: HTMLElement;
}

export class BodyRows {
  readonly #list: BodyList;
  readonly #onEnlarge: (engineId: string) => void;
  readonly #holders: BodyHolders;
  readonly #element = byTestId("body-list", HTMLElement);
  readonly #search = byTestId("body-search", HTMLInputElement);
  readonly #count = byTestId("body-count", HTMLElement);
  readonly #rows = byTestId("body-rows", HTMLElement);
  readonly #more = byTestId("body-more", HTMLButtonElement);
  readonly #byId = new Map<string, Row>();

  /**
   * @param onList is called when other bodies are listed: another text is searched, or one page more is shown
   * @param onEnlarge is called with the body that the visitor wants to see large
   */
  constructor(client: Client, list: BodyList, onList: () => void, onEnlarge: (engineId: string) => void) {
    this.#list = list;
    this.#onEnlarge = onEnlarge;
    this.#holders = new BodyHolders(client, () => this.#renderStatus());
    this.#search.addEventListener("input", () => {
      list.search = this.#search.value;
      onList();
    });
    this.#more.addEventListener("click", () => {
      const first = list.listed.length;
      list.showMore();
      onList();
      // The button may be gone now: the keyboard goes on with what has come.
      this.#rows.children[first]?.querySelector("button")?.focus();
    });
  }

  /**
   * @param shown whether the bodies are shown in short
   * @param ranked whether this page's token names a rank that counts
   */
  update(shown: boolean, ranked: boolean): void {
    this.#holders.ranked = ranked;
    const wasShown = !this.#element.hidden;
    this.#element.hidden = !shown;
    if (!shown && !wasShown) return;
    const listed = shown ? this.#list.listed : [];
    this.#holders.watch(listed);
    const ids = new Set(listed.map(({ engineId }) => engineId));
    for (const [engineId, { element }] of this.#byId) {
      if (ids.has(engineId)) continue;
      element.remove();
      this.#byId.delete(engineId);
    }
    for (const [place, body] of listed.entries()) {
      const { element } = this.#row(body);
      const there = this.#rows.children[place] ?? null;
      if (there !== element) this.#rows.insertBefore(element, there);
    }
    this.#renderCount();
    this.#renderStatus();
  }

  #row({ engineId }: PageBody): Row {
    const known = this.#byId.get(engineId);
    if (known) return known;
    const status = make("span", { class: "body-status" });
    const label = { type: "button", class: "button small", "aria-label": `Show large: ${engineId}` };
    const button = make("button", label, "Show large");
    button.addEventListener("click", () => this.#onEnlarge(engineId));
    const name = make("span", { class: "body-id", title: engineId }, engineId);
    const row = { element: make("li", { "data-engine": engineId }, name, status, button), status };
    this.#byId.set(engineId, row);
    return row;
  }

  #renderCount(): void {
    const { count, found, listed, more, search } = this.#list;
    if (this.#search.value !== search) this.#search.value = search;
    const of =
      search.trim() === "" ? `${listed.length} of ${count} are shown` : `${found} of ${count} are found`;
    setText(this.#count, found === 0 ? "Nothing is found." : of);
    this.#more.hidden = more === 0;
    setText(this.#more, `Show ${more} more`);
  }

  #renderStatus(): void {
    for (const body of this.#list.listed) {
      const status = this.#byId.get(body.engineId)?.status;
      if (!status) continue;
      const holding = this.#holders.of(body);
      status.dataset["holding"] = holding?.kind ?? "";
      setText(status, holdingWords(holding));
    }
  }
}

function holdingWords(holding: Holding | null): string {
  switch (holding?.kind) {
    case undefined:
      return "";
    case "free":
      return "Free";
    case "mine":
      return "You have control";
    case "held":
      return `${holding.holder} has control`;
  }
}
