/** The line in which a person types what the avatar shall say. */

import { SpeechSynthesis } from "../sdk/index.ts";
import type { Client } from "../sdk/index.ts";
import { ComponentWatch, isUsable } from "./component_status.ts";
import type { Availability } from "./component_status.ts";
import { byRole, byTestId, make, setText } from "./dom.ts";
import { languageChoice } from "./languages.ts";
import { describeEnd, describeFailure } from "./outcome.ts";
import { explain } from "./permission.ts";
import { SpeechWords } from "./speech_words.ts";

type State = "idle" | "speaking" | "paused" | "done" | "stopped" | "failed" | "refused" | "unavailable";

const BUSY = "another visitor is speaking through the avatar; try again in a moment";

export class SayLine {
  readonly #client: Client;
  readonly #form = byRole("say", HTMLFormElement);
  readonly #input = byTestId("say-text", HTMLInputElement);
  readonly #language = byTestId("say-language", HTMLSelectElement);
  readonly #send = byTestId("say-send", HTMLButtonElement);
  readonly #stop = byTestId("say-stop", HTMLButtonElement);
  readonly #pause = byTestId("say-pause", HTMLButtonElement);
  readonly #state = byTestId("say-state", HTMLElement);
  readonly #watch: ComponentWatch;
  readonly #words: SpeechWords;
  readonly #onCut: (cut: Promise<unknown>) => void;
  #speech: SpeechSynthesis | null = null;
  #usable = false;
  #barred = "";
  #performance = 0;
  #stopping = new AbortController();
  #last = "";

  /** @param onCut is told that speech is being broken off, and when that is done */
  constructor(client: Client, onCut: (cut: Promise<unknown>) => void) {
    this.#client = client;
    this.#onCut = onCut;
    this.#words = new SpeechWords(client, () => onCut(Promise.resolve()));
    this.#watch = new ComponentWatch(client, (status) => this.#available(status));
    this.#form.addEventListener("submit", (event) => {
      event.preventDefault();
      void this.#speak();
    });
    this.#stop.addEventListener("click", () => this.stop());
    this.#pause.addEventListener("click", () => void this.#togglePause());
    this.#input.addEventListener("keydown", (event) => {
      if (event.key !== "ArrowUp" || this.#input.value !== "" || this.#last === "") return;
      event.preventDefault();
      this.#input.value = this.#last;
    });
    this.#render();
  }

  /** Whether the avatar can speak at all, now or when it is back. */
  set offered(offered: boolean) {
    this.#form.hidden = !offered;
  }

  /** @param componentRef,progress the components SpeechSynthesis and SpeechProgress; null when there is none or it is away */
  setComponents(componentRef: string | null, progress: string | null): void {
    this.#words.setComponent(progress);
    if (componentRef !== null && this.#speech?.componentRef !== componentRef) {
      this.#speech = new SpeechSynthesis(this.#client, componentRef);
    }
    this.#watch.watch(componentRef);
  }

  /** Why nothing can be said; empty where it can. */
  set barred(barred: string) {
    this.#barred = barred;
    this.#input.placeholder = barred !== "" ? "Your token lets you watch only" : "Say something";
    for (const control of [this.#input, this.#send]) explain(control, barred);
    this.#render();
  }

  focus(): void {
    this.#input.focus();
  }

  stop(): void {
    if (!this.#speech || !this.#speaking) return;
    this.#stopping.abort();
    if (this.#speech.inUse) this.#onCut(this.#speech.stop().catch(() => undefined));
  }

  get #speaking(): boolean {
    const state = this.#state.dataset["state"];
    return state === "speaking" || state === "paused";
  }

  async #togglePause(): Promise<void> {
    const paused = this.#state.dataset["state"] === "paused";
    const performance = this.#performance;
    try {
      await (paused ? this.#speech?.resume() : this.#speech?.suspend());
    } catch (error) {
      if (performance === this.#performance) setText(this.#state, describeFailure(error, BUSY).text);
      return;
    }
    // It may have come to its end meanwhile.
    if (performance !== this.#performance || !this.#speaking) return;
    if (paused) this.#show("speaking", "speaking");
    else this.#show("paused", "paused");
  }

  async #speak(): Promise<void> {
    const text = this.#input.value.trim();
    const speech = this.#speech;
    if (!speech || !this.#usable || this.#barred !== "") return;
    if (text === "") return this.focus();
    const performance = ++this.#performance;
    const language = this.#language.value;
    const parameters = { speech_text: text, ...(language !== "" && { language }) };
    const { signal } = (this.#stopping = new AbortController());
    this.#show("speaking", "speaking");
    await this.#words.begin(text);
    if (performance !== this.#performance) return;
    if (signal.aborted) {
      this.#words.end();
      return this.#show("stopped", "stopped");
    }
    const spoken = speech.perform(parameters, () => {
      this.#last = text;
      if (this.#input.value.trim() === text) this.#input.value = "";
    });
    const { state, text: words } = await describeEnd(spoken, BUSY);
    // A sentence that the next one has cut short is nobody's concern any more.
    if (performance !== this.#performance) return;
    this.#words.end();
    this.#show(state, words);
  }

  #available(status: Availability): void {
    const usable = isUsable(status);
    if (usable && !this.#usable) void this.#fillLanguages();
    this.#usable = usable;
    if (usable && this.#state.dataset["state"] === "unavailable") this.#show("idle", "");
    if (!usable && status !== null) {
      this.#show(
        "unavailable",
        `speech is not available: the component reports ${status}. Install it beside the avatar with “pip install openrois[speech]”.`,
      );
    }
    this.#render();
  }

  async #fillLanguages(): Promise<void> {
    const speech = this.#speech;
    if (!speech) return;
    try {
      const { languages: tags } = await speech.synthesizableLanguages();
      const { options, selected } = languageChoice(tags, this.#language.value, navigator.languages);
      this.#language.replaceChildren(...options.map(({ tag, name }) => make("option", { value: tag }, name)));
      this.#language.value = selected;
      this.#language.hidden = options.length === 0;
    } catch {
      this.#language.hidden = true;
    }
  }

  #show(state: State, text: string): void {
    this.#state.dataset["state"] = state;
    setText(this.#state, text === "" ? "" : `${text.charAt(0).toUpperCase()}${text.slice(1)}`);
    this.#render();
  }

  #render(): void {
    const disabled = !this.#usable || this.#barred !== "";
    this.#input.disabled = this.#language.disabled = this.#send.disabled = disabled;
    const paused = this.#state.dataset["state"] === "paused";
    this.#stop.disabled = this.#pause.disabled = !this.#usable || !this.#speaking;
    this.#pause.setAttribute("aria-label", paused ? "Go on" : "Pause");
    this.#pause.title = paused ? "Go on" : "Pause";
    this.#pause.classList.toggle("paused", paused);
  }
}
