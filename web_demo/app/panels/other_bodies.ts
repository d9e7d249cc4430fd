/** The bodies that are not shown large: a card each, at the side or beside the large picture. */

import type { Client } from "../../sdk/index.ts";
import type { MediaReceiver } from "../../sdk/media/index.ts";
import { byRole, byTestId } from "../dom/elements.ts";
import type { PageBody } from "../model/bodies.ts";
import { BodyCard } from "./body_card.ts";

/** Where the browser keeps that two bodies are shown in the same size. */
const KEY = "openrois.layout";
const EVEN = "side by side";

export class OtherBodies {
  readonly #client: Client;
  readonly #receiver: MediaReceiver;
  readonly #onEnlarge: (engineId: string) => void;
  readonly #element = byRole("others", HTMLElement);
  readonly #layout = byRole("view-avatar", HTMLElement);
  readonly #button = byTestId("layout-toggle", HTMLButtonElement);
  readonly #cards = new Map<string, BodyCard>();
  #even = localStorage.getItem(KEY) === EVEN;

  /** @param onEnlarge is called with the body that the visitor wants to see large */
  constructor(client: Client, receiver: MediaReceiver, onEnlarge: (engineId: string) => void) {
    this.#client = client;
    this.#receiver = receiver;
    this.#onEnlarge = onEnlarge;
    this.#button.addEventListener("click", () => {
      this.#even = !this.#even;
      localStorage.setItem(KEY, this.#even ? EVEN : "");
      this.#place();
    });
    this.#place();
  }

  /**
   * @param bodies all bodies that can be seen now
   * @param chosen the one that is shown large
   * @param watching why the visitor may only watch; empty where it may operate
   */
  update(bodies: readonly PageBody[], chosen: string, watching: string): void {
    const others = new Map(
      bodies.filter((each) => each.engineId !== chosen).map((each) => [each.engineId, each]),
    );
    for (const [engineId, card] of this.#cards) {
      const present = others.get(engineId) ?? null;
      if (engineId === chosen || (present === null && bodies.length > 0)) {
        this.#cards.delete(engineId);
        card.close(engineId === chosen);
      } else card.update(present, watching);
    }
    for (const [engineId, body] of others) {
      if (this.#cards.has(engineId)) continue;
      const card = new BodyCard(this.#client, this.#receiver, body, () => this.#onEnlarge(engineId));
      this.#cards.set(engineId, card);
      this.#element.append(card.element);
      card.update(body, watching);
    }
    this.#place();
  }

  /** @param visible whether the bodies are in view */
  render(visible: boolean): void {
    for (const card of this.#cards.values()) card.render(visible);
  }

  #place(): void {
    const some = this.#cards.size > 0;
    this.#element.hidden = this.#button.hidden = !some;
    this.#button.setAttribute("aria-pressed", String(this.#even));
    this.#layout.classList.toggle("even", some && this.#even);
  }
}
