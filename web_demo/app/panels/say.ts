/** Speech form: text to speak, language, queue, pause and stop. */

import { CommandFailed, SpeechSynthesis } from "../../sdk/index.ts";
import type { Client } from "../../sdk/index.ts";
import { ComponentWatch, isUsable } from "../model/component_status.ts";
import type { Availability } from "../model/component_status.ts";
import { byRole, byTestId, make, setText } from "../dom/elements.ts";
import { languageChoice, languageName, recallLanguages, rememberLanguage } from "../model/languages.ts";
import type { LanguageOption } from "../model/languages.ts";
import { describeEnd, describeFailure } from "../model/outcome.ts";
import { PassingText } from "../dom/passing_text.ts";
import { SpeechProgress } from "../model/own_components.ts";
import { explain } from "../model/permission.ts";
import { sentence } from "../model/plain_words.ts";
import { spellingHint } from "../model/scripts.ts";
import { speak } from "../model/speech_loan.ts";
import { textsSentToWords } from "../model/sent_to.ts";
import { QueueRefusal, SpeechQueue } from "../model/speech_queue.ts";
import type { Utterance } from "../model/speech_queue.ts";
import { SpeechWords } from "./speech_words.ts";

type State = "idle" | "speaking" | "paused" | "done" | "stopped" | "failed" | "refused" | "unavailable";

const BUSY = "another visitor is speaking through the body; try again in a moment";

export class SayLine {
  readonly #client: Client;
  readonly #form = byRole("say", HTMLFormElement);
  readonly #input = byTestId("say-text", HTMLInputElement);
  readonly #language = byTestId("say-language", HTMLSelectElement);
  readonly #send = byTestId("say-send", HTMLButtonElement);
  readonly #stop = byTestId("say-stop", HTMLButtonElement);
  readonly #pause = byTestId("say-pause", HTMLButtonElement);
  readonly #state = byTestId("say-state", HTMLElement);
  readonly #hint = byTestId("say-hint", HTMLElement);
  readonly #list = byTestId("say-queue", HTMLOListElement);
  readonly #queue = new SpeechQueue();
  readonly #stateText = new PassingText(this.#state, () => this.#show("idle", ""));
  readonly #watch: ComponentWatch;
  readonly #words: SpeechWords;
  readonly #onCut: (cut: Promise<unknown>) => void;
  /** Whether this page's token names a rank that counts. */
  ranked = false;
  #speech: SpeechSynthesis | null = null;
  #usable = false;
  /** Of the component SpeechProgress that was asked where texts are sent. */
  #asked: string | null = null;
  #sentTo = "";
  #hasLanguages = false;
  #barred = "";
  #performance = 0;
  /** Whether the queue is being spoken. */
  #running = false;
  #stopping = new AbortController();
  #last = "";

  /** @param onCut is called when speech is interrupted, with a promise for the end of that */
  constructor(client: Client, onCut: (cut: Promise<unknown>) => void) {
    this.#client = client;
    this.#onCut = onCut;
    this.#words = new SpeechWords(client, () => onCut(Promise.resolve()));
    this.#watch = new ComponentWatch(client, (status) => this.#available(status));
    this.#form.addEventListener("submit", (event) => {
      event.preventDefault();
      this.#submit();
    });
    this.#input.addEventListener("input", () => this.#renderHint());
    this.#language.addEventListener("change", () => {
      rememberLanguage(localStorage, this.#language.value);
      this.#renderHint();
    });
    this.#stop.addEventListener("click", () => this.stop());
    this.#pause.addEventListener("click", () => void this.#togglePause());
    this.#input.addEventListener("keydown", (event) => {
      if (event.key !== "ArrowUp" || this.#input.value !== "" || this.#last === "") return;
      event.preventDefault();
      this.#input.value = this.#last;
    });
    // In full screen what lies upon the picture stands above this form.
    new ResizeObserver(() =>
      document.documentElement.style.setProperty("--say-height", `${this.#form.offsetHeight}px`),
    ).observe(this.#form);
    this.#render();
  }

  /** Whether the avatar can speak at all, now or when it is back. */
  set offered(offered: boolean) {
    this.#form.hidden = !offered;
  }

  /** @param componentRef,progress the components SpeechSynthesis and SpeechProgress; null when there is none or it is away */
  setComponents(componentRef: string | null, progress: string | null): void {
    this.#words.setComponent(progress);
    if (progress !== this.#asked) void this.#askSynthesizer(progress);
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

  /** Stops speech and clears the queue. */
  stop(): void {
    this.#queue.clear();
    this.#renderQueue();
    if (!this.#speech || !this.speaking) return;
    this.#stopping.abort();
    if (this.#speech.inUse) this.#onCut(this.#speech.stop().catch(() => undefined));
  }

  /** Whether this page speaks through the body. */
  get speaking(): boolean {
    const state = this.#state.dataset["state"];
    return state === "speaking" || state === "paused";
  }

  async #togglePause(): Promise<void> {
    const paused = this.#state.dataset["state"] === "paused";
    const performance = this.#performance;
    try {
      await (paused ? this.#speech?.resume() : this.#speech?.suspend());
    } catch (error) {
      if (performance === this.#performance)
        this.#stateText.show(sentence(describeFailure(error, BUSY).text), false);
      return;
    }
    // It may have come to its end meanwhile.
    if (performance !== this.#performance || !this.speaking) return;
    if (paused) this.#show("speaking", "speaking");
    else this.#show("paused", "paused");
  }

  /** Speaks what was typed, behind what is being spoken. */
  #submit(): void {
    const text = this.#input.value.trim();
    if (!this.#speech || !this.#usable || this.#barred !== "") return;
    if (text === "" && this.#queue.waiting.length === 0) return this.focus();
    try {
      if (text !== "") this.#queue.add(text, this.#language.value);
    } catch (error) {
      if (!(error instanceof QueueRefusal)) throw error;
      return this.#showHint(error.message);
    }
    if (text !== "") this.#last = text;
    this.#input.value = "";
    this.#renderHint();
    this.#renderQueue();
    void this.#speakAll();
  }

  /** Speaks all that waits, until something ends otherwise than well. */
  async #speakAll(): Promise<void> {
    if (this.#running) return;
    this.#running = true;
    for (let utterance = this.#queue.next(); utterance; utterance = this.#queue.next()) {
      this.#renderQueue();
      const state = await this.#speak(utterance);
      if (state === "done") continue;
      // A stop means silence; what could not be spoken is kept, to be tried again.
      if (state === "stopped") this.#queue.clear();
      else if (this.#input.value === "" && this.#queue.waiting.length === 0)
        this.#input.value = utterance.text;
      else this.#queue.putBack(utterance);
      break;
    }
    this.#running = false;
    this.#renderQueue();
  }

  async #speak({ text, ssml, language }: Utterance): Promise<State> {
    const speech = this.#speech;
    if (!speech) return "failed";
    this.#performance += 1;
    const parameters = {
      ...(ssml ? { ssml_text: text } : { speech_text: text }),
      ...(language !== "" && { language }),
    };
    const { signal } = (this.#stopping = new AbortController());
    this.#show("speaking", "speaking");
    const { control } = this.#client;
    const spoken = async (): Promise<void> => {
      await control.unlessStopped(speech.componentRef, () => this.#words.beginText(text, ssml));
      if (signal.aborted) throw new CommandFailed("speech", "", "ABORT", "stopped");
      await speak(control, speech, parameters, this.ranked, signal);
    };
    const { state, text: words } = await describeEnd(spoken(), BUSY);
    this.#words.endText();
    this.#show(state, words);
    return state;
  }

  #available(status: Availability): Promise<void> | void {
    const usable = isUsable(status);
    this.#usable = usable;
    if (!usable) this.#hasLanguages = false;
    if (usable && this.#state.dataset["state"] === "unavailable") this.#show("idle", "");
    if (!usable && status !== null) {
      this.#show(
        "unavailable",
        `speech is not available. Install it beside the body's adapter with “pip install openrois[speech]”.`,
      );
    }
    this.#render();
    return usable && !this.#hasLanguages ? this.#fillLanguages() : undefined;
  }

  async #fillLanguages(): Promise<void> {
    const speech = this.#speech;
    if (!speech) return;
    try {
      const { languages: tags } = await speech.synthesizableLanguages();
      const { recent, others, selected } = languageChoice(
        tags,
        recallLanguages(localStorage),
        navigator.languages,
      );
      const groups = [
        ["Recent", recent],
        ["All", others],
      ] as const;
      const named = groups.filter(([, options]) => options.length > 0);
      this.#language.replaceChildren(
        ...(named.length > 1
          ? named.map(([label, options]) => make("optgroup", { label }, ...options.map(option)))
          : named.flatMap(([, options]) => options.map(option))),
      );
      this.#language.value = selected;
      this.#language.hidden = named.length === 0;
      this.#hasLanguages = true;
      this.#renderHint();
    } catch (error) {
      this.#language.hidden = true;
      throw error;
    }
  }

  /** Says where texts are sent; a body that does not tell keeps them. */
  async #askSynthesizer(progress: string | null): Promise<void> {
    this.#asked = progress;
    const component = progress === null ? null : new SpeechProgress(this.#client, progress);
    const told = await component?.synthesizer().catch(() => null);
    if (progress !== this.#asked) return;
    this.#sentTo = textsSentToWords(told?.sent_to ?? "");
    this.#renderHint();
  }

  #renderHint(): void {
    const { value } = this.#language;
    const hint = spellingHint(this.#input.value, value, languageName(value));
    this.#showHint([hint, this.#sentTo].filter((each) => each !== "").join(" "));
  }

  #showHint(text: string): void {
    this.#hint.hidden = text === "";
    setText(this.#hint, text);
  }

  #renderQueue(): void {
    const { waiting } = this.#queue;
    this.#list.hidden = waiting.length === 0;
    this.#list.replaceChildren(
      ...waiting.map(({ id, text }) => {
        const remove = make("button", { type: "button", "aria-label": `Remove “${text.slice(0, 40)}”` }, "×");
        remove.addEventListener("click", () => {
          this.#queue.remove(id);
          this.#renderQueue();
          this.focus();
        });
        return make("li", {}, make("span", {}, text), remove);
      }),
    );
  }

  #show(state: State, text: string): void {
    this.#state.dataset["state"] = state;
    this.#stateText.show(sentence(text), state !== "unavailable" && !this.speaking);
    this.#render();
  }

  #render(): void {
    const disabled = !this.#usable || this.#barred !== "";
    this.#input.disabled = this.#language.disabled = this.#send.disabled = disabled;
    const paused = this.#state.dataset["state"] === "paused";
    this.#stop.disabled = this.#pause.disabled = !this.#usable || !this.speaking;
    this.#pause.setAttribute("aria-label", paused ? "Go on" : "Pause");
    this.#pause.title = paused ? "Go on" : "Pause";
    this.#pause.classList.toggle("paused", paused);
  }
}

function option({ tag, name }: LanguageOption): HTMLOptionElement {
  return make("option", { value: tag }, name);
}
