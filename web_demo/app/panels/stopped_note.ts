/** Note that a person has stopped a body: programs wait, until a person presses "Hand back to programs". */

import { RoISError } from "../../sdk/index.ts";
import { byRole, byTestId, setText } from "../dom/elements.ts";
import { describeFailure } from "../model/outcome.ts";
import { named, plainReason, sentence } from "../model/plain_words.ts";
import type { StoppedBodies } from "../model/stopped_bodies.ts";

export class StoppedNote {
  readonly #bodies: StoppedBodies;
  readonly #note = byTestId("stopped", HTMLElement);
  readonly #words = byRole("stopped-words", HTMLElement);
  readonly #button = byTestId("stopped-hand-back", HTMLButtonElement);
  #watching = false;
  /** Why the body could not be handed back, with the body that is meant. */
  #refused: { readonly engineId: string; readonly why: string } | null = null;

  constructor(bodies: StoppedBodies) {
    this.#bodies = bodies;
    this.#button.addEventListener("click", () => void this.#handBack());
  }

  /** Whether the visitor may only watch, and has no button. */
  set watching(watching: boolean) {
    this.#watching = watching;
    this.render();
  }

  render(): void {
    const stopped = this.#bodies.first;
    this.#note.hidden = stopped === null;
    this.#button.hidden = this.#watching;
    if (stopped === null) return;
    const { engineId, by } = stopped;
    const refused = this.#refused?.engineId === engineId ? ` ${this.#refused.why}.` : "";
    setText(this.#words, `${named(by)} has stopped ${engineId}. Programs wait.${refused}`);
  }

  async #handBack(): Promise<void> {
    const stopped = this.#bodies.first;
    if (stopped === null) return;
    const { engineId } = stopped;
    this.#refused = null;
    try {
      await this.#bodies.handBack(engineId);
    } catch (error) {
      const why = error instanceof RoISError ? plainReason(error.reason) : "";
      this.#refused = { engineId, why: sentence(why || describeFailure(error).text) };
    }
    this.render();
  }
}
