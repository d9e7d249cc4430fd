/** Captions on the picture, for speech of any application. */

import type { Client, Subscription } from "../../sdk/index.ts";
import { Caption } from "../model/caption_text.ts";
import { byTestId, make } from "../dom/elements.ts";
import { SpeechProgress } from "../model/own_components.ts";

const KEY = "openrois.captions";
/** Milliseconds for which the last words stay. */
const AFTER = 1500;

export class Captions {
  readonly #client: Client;
  readonly #element = byTestId("captions", HTMLElement);
  readonly #button = byTestId("captions-toggle", HTMLButtonElement);
  #progress: SpeechProgress | null = null;
  #listening: Promise<Subscription>[] = [];
  #caption: Caption | null = null;
  #fading: ReturnType<typeof setTimeout> | undefined;
  #on = recall();

  constructor(client: Client) {
    this.#client = client;
    this.#button.addEventListener("click", () => this.toggle());
    this.#follow();
  }

  /** @param componentRef the SpeechProgress component; null when the avatar has none or is away */
  setComponent(componentRef: string | null): void {
    this.#button.hidden = componentRef === null && this.#progress === null;
    if (componentRef === null) return this.#show(null);
    if (componentRef === this.#progress?.componentRef) return this.#follow();
    this.#unfollow();
    this.#progress = new SpeechProgress(this.#client, componentRef);
    this.#follow();
  }

  toggle(): void {
    if (this.#button.hidden) return;
    this.#on = !this.#on;
    try {
      localStorage.setItem(KEY, this.#on ? "on" : "off");
    } catch {
      // Forbidden: it holds until the page is loaded again.
    }
    if (!this.#on) this.#unfollow();
    this.#follow();
  }

  #follow(): void {
    this.#button.setAttribute("aria-pressed", String(this.#on));
    const progress = this.#progress;
    if (!this.#on || !progress || this.#listening.length > 0) return;
    const listening = [
      progress.speechBegan.subscribe(({ speech_id: id, text, is_ssml: ssml }) =>
        this.#show(new Caption(id, text === "" ? null : text, ssml)),
      ),
      progress.wordSpoken.subscribe(({ speech_id: id, word, position, length }) => {
        const caption = this.#caption?.id === id ? this.#caption : new Caption(id, null);
        caption.wordHeard(word, position, length);
        this.#show(caption);
      }),
      progress.speechEnded.subscribe(({ speech_id: id, status }) => {
        if (this.#caption?.id !== id) return;
        clearTimeout(this.#fading);
        this.#fading = setTimeout(() => this.#show(null), status === "OK" ? AFTER : 0);
      }),
    ];
    this.#listening = listening;
    // An engine of another make may lack some of these events: what there is, is shown.
    Promise.allSettled(listening).then((all) => {
      const nothing = all.every(({ status }) => status === "rejected");
      if (nothing && this.#listening === listening) this.#listening = [];
    });
  }

  #unfollow(): void {
    for (const each of this.#listening.splice(0))
      void each.then((subscription) => subscription.cancel()).catch(() => undefined);
    this.#show(null);
  }

  #show(caption: Caption | null): void {
    clearTimeout(this.#fading);
    this.#caption = caption;
    this.#element.hidden = caption === null;
    if (!caption) return this.#element.replaceChildren();
    const { before, word, after } = caption.shown;
    this.#element.replaceChildren(before, ...(word === "" ? [] : [make("mark", {}, word)]), after);
  }
}

function recall(): boolean {
  try {
    return localStorage.getItem(KEY) !== "off";
  } catch {
    return true;
  }
}
