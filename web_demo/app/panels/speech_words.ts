/** The text being spoken, with its current word. */

import type { Client, Subscription } from "../../sdk/index.ts";
import { byTestId, make } from "../dom/elements.ts";
import { SpeechProgress } from "../model/own_components.ts";
import { SpokenText } from "../model/spoken_text.ts";

export class SpeechWords {
  readonly #client: Client;
  readonly #onCut: () => void;
  readonly #element = byTestId("say-words", HTMLElement);
  #progress: SpeechProgress | null = null;
  #listening: Promise<Subscription>[] = [];
  #text: SpokenText | null = null;
  #lastId = "";

  /** @param onCut is called when speech was broken off */
  constructor(client: Client, onCut: () => void) {
    this.#client = client;
    this.#onCut = onCut;
  }

  /** @param componentRef the SpeechProgress component; null when the avatar has none or is away */
  setComponent(componentRef: string | null): void {
    if (componentRef === null || componentRef === this.#progress?.componentRef) return;
    for (const each of this.#listening.splice(0))
      void each.then((subscription) => subscription.cancel()).catch(() => undefined);
    this.#progress = new SpeechProgress(this.#client, componentRef);
  }

  /** Shows a text or SSML document about to be spoken. Resolves when its words will be reported. */
  async beginText(text: string, ssml: boolean): Promise<void> {
    this.#text = new SpokenText(text, this.#lastId, ssml);
    this.#render();
    const progress = this.#progress;
    if (!progress) return;
    if (this.#listening.length === 0) {
      this.#listening = [
        progress.wordSpoken.subscribe(({ speech_id: id, position, length }) => {
          if (this.#text?.wordHeard(id, position, length)) this.#render();
          this.#lastId = id;
        }),
        progress.speechEnded.subscribe(({ status }) => {
          if (status === "ABORT") this.#onCut();
        }),
      ];
    }
    // Without these events the avatar speaks all the same.
    await Promise.all(this.#listening).catch(() => (this.#listening = []));
  }

  endText(): void {
    this.#text = null;
    this.#render();
  }

  #render(): void {
    this.#element.hidden = this.#text === null;
    if (!this.#text) return;
    const { before, word, after } = this.#text.parts;
    const mark = make("mark", {}, word);
    this.#element.replaceChildren(before, ...(word === "" ? [] : [mark]), make("span", {}, after));
    if (word === "") this.#element.scrollLeft = 0;
    else this.#element.scrollLeft = mark.offsetLeft - this.#element.clientWidth / 3;
  }
}
