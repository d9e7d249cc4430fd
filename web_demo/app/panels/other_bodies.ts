/**
 * The bodies that are not shown large: a card each, at the side or beside the large picture. Where there are too many for
 * that, a list of them, and cards of those alone that the visitor operates.
 */

import type { Client } from "../../sdk/index.ts";
import type { MediaReceiver } from "../../sdk/media/index.ts";
import { byRole, byTestId } from "../dom/elements.ts";
import type { PageBody } from "../model/bodies.ts";
import { BodyList } from "../model/body_list.ts";
import type { Rights } from "../model/permission.ts";
import { BodyCard } from "./body_card.ts";
import { BodyRows } from "./body_rows.ts";

/** Where the browser keeps that two bodies are shown in the same size. */
const KEY = "openrois.layout";
const EVEN = "side by side";

export class OtherBodies {
  readonly #client: Client;
  readonly #receiver: MediaReceiver;
  readonly #isUsed: () => boolean;
  readonly #onEnlarge: (engineId: string) => void;
  readonly #element = byRole("others", HTMLElement);
  readonly #layout = byRole("view-avatar", HTMLElement);
  readonly #button = byTestId("layout-toggle", HTMLButtonElement);
  readonly #list = new BodyList();
  readonly #rows: BodyRows;
  readonly #cards = new Map<string, BodyCard>();
  #bodies: readonly PageBody[] = [];
  #rights: Rights = { watching: "", ranked: false };
  #even = localStorage.getItem(KEY) === EVEN;

  /**
   * @param isUsed returns whether the visitor has used the page a moment ago
   * @param onEnlarge is called with the body that the visitor wants to see large
   */
  constructor(
    client: Client,
    receiver: MediaReceiver,
    isUsed: () => boolean,
    onEnlarge: (engineId: string) => void,
  ) {
    this.#client = client;
    this.#receiver = receiver;
    this.#isUsed = isUsed;
    this.#onEnlarge = onEnlarge;
    this.#rows = new BodyRows(
      client,
      this.#list,
      () => this.#rows.update(true, this.#rights.ranked),
      onEnlarge,
    );
    this.#button.addEventListener("click", () => {
      this.#even = !this.#even;
      localStorage.setItem(KEY, this.#even ? EVEN : "");
      this.#place();
    });
    this.#place();
  }

  /** Those of all bodies that a visitor may choose from at once. */
  get offered(): readonly PageBody[] {
    return this.#list.isLong ? this.#list.listed : this.#bodies;
  }

  /** The bodies that have a card, and are there. */
  get carded(): readonly PageBody[] {
    return [...this.#cards.values()].flatMap(({ present }) => (present ? [present] : []));
  }

  /** Whether a body that is not shown large any more goes on in a card. */
  get hasCards(): boolean {
    return !this.#list.isLong;
  }

  /**
   * @param bodies all bodies that can be seen now
   * @param chosen the one that is shown large
   */
  update(bodies: readonly PageBody[], chosen: string, rights: Rights): void {
    if (bodies.length > 0) {
      this.#bodies = bodies;
      this.#list.setBodies(bodies, chosen);
    }
    const { isLong } = this.#list;
    const changed = rights.watching !== this.#rights.watching || rights.ranked !== this.#rights.ranked;
    const others = new Map(
      bodies.filter((each) => each.engineId !== chosen).map((each) => [each.engineId, each]),
    );
    for (const [engineId, card] of this.#cards) {
      const present = others.get(engineId) ?? null;
      if (engineId === chosen || (present === null && bodies.length > 0)) {
        this.#cards.delete(engineId);
        card.close(engineId === chosen);
      } else if (present !== card.present || changed) card.update(present, rights);
    }
    this.#rights = rights;
    this.#closeIdle();
    this.#rows.update(isLong, rights.ranked);
    for (const [engineId, body] of isLong ? [] : others) {
      if (this.#cards.has(engineId)) continue;
      const card = new BodyCard(this.#client, this.#receiver, body, this.#isUsed, () =>
        this.#onEnlarge(engineId),
      );
      this.#cards.set(engineId, card);
      this.#element.append(card.element);
      card.update(body, rights);
    }
    this.#place();
  }

  /** @param visible whether the bodies are in view */
  render(visible: boolean): void {
    if (this.#closeIdle()) this.#place();
    for (const card of this.#cards.values()) card.render(visible);
  }

  /** Where bodies are listed: closes the cards of those that the visitor does not operate; returns whether there were any. */
  #closeIdle(): boolean {
    const idle = [...this.#cards.values()].filter((card) => this.#list.isLong && !card.isOperated);
    for (const card of idle) {
      this.#cards.delete(card.engineId);
      card.close(false);
    }
    return idle.length > 0;
  }

  #place(): void {
    const some = this.#cards.size > 0;
    this.#element.hidden = !some && !this.#list.isLong;
    this.#button.hidden = !some;
    this.#button.setAttribute("aria-pressed", String(this.#even));
    this.#layout.classList.toggle("even", some && this.#even);
  }
}
