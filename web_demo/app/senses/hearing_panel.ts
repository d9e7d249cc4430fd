/** Panel of the microphone: levels, transcription, and interruption of speech. */

import type { Client } from "../../sdk/index.ts";
import { SILENCE } from "../model/decibels.ts";
import { make, setText } from "../dom/elements.ts";
import { LevelBar, TrackLevel } from "../dom/level_bar.ts";
import { describeFailure } from "../model/outcome.ts";
import { sentence } from "../model/plain_words.ts";
import { Hearing, Operator, SpeechProgress } from "../model/own_components.ts";
import { sentToWords } from "../model/sent_to.ts";
import type { Recognizer } from "../model/sent_to.ts";
import { Switch } from "./switch.ts";
import { Wanted } from "./wanted.ts";
import { isOwn } from "../model/consent.ts";

/** So many sentences are kept in view. */
const KEPT = 3;
const BUSY = "Another visitor uses it now";

export class HearingPanel {
  /** The visitor that this page is; empty while that is not known. */
  visitorRef = "";
  readonly element = make("div", { class: "sense" });
  readonly #client: Client;
  readonly #onChange: () => void;
  readonly #here = new LevelBar("here", "Here");
  readonly #there = new LevelBar("there", "At the body");
  readonly #local = new TrackLevel((level) => this.#here.show(level));
  readonly #level = new Wanted();
  readonly #heard = new Wanted((error) => this.#refused(error));
  readonly #switch: Switch;
  readonly #interrupt: Switch;
  readonly #list = make("ol", { class: "heard", "data-testid": "heard", "aria-live": "polite" });
  readonly #sentTo = make("p", { class: "sense-words", role: "status", "data-testid": "sent-to" });
  readonly #words = make("p", { class: "sense-words", role: "status" });
  #operator: Operator | null = null;
  #hearing: Hearing | null = null;
  #progress: SpeechProgress | null = null;
  #recognizer: Recognizer | null = null;
  #agrees = true;
  #track: MediaStreamTrack | null = null;
  #sentences: readonly string[] = [];

  /** @param onChange is called when it begins to write down, or ends */
  constructor(client: Client, onChange: () => void) {
    this.#client = client;
    this.#onChange = onChange;
    this.#switch = new Switch("hearing-switch", "Let it write down what you say", () => this.#update());
    this.#interrupt = new Switch("barge-in", "Speak to interrupt it", (on) => void this.#setInterrupt(on));
    const levels = make("div", { class: "levels" }, this.#here.element, this.#there.element);
    this.element.append(
      levels,
      this.#switch.element,
      this.#list,
      this.#interrupt.element,
      this.#sentTo,
      this.#words,
    );
    this.#update();
  }

  /** Whether the sound may go to another machine, as far as the body asks for that. */
  set agrees(agrees: boolean) {
    this.#agrees = agrees;
    this.#showSentTo();
  }

  /** Whether the avatar writes down for this page what it hears. */
  get listens(): boolean {
    return this.#heard.wanted;
  }

  /** @param operator,hearing,progress refs of components; null where there are none */
  setComponents(operator: string | null, hearing: string | null, progress: string | null): void {
    if (operator !== (this.#operator?.componentRef ?? null)) {
      const component = operator === null ? null : new Operator(this.#client, operator);
      this.#operator = component;
      this.#level.from(
        component &&
          (() =>
            component.microphoneLevel.subscribe((level) => {
              if (isOwn(level, this.visitorRef)) this.#there.show(level);
            })),
      );
    }
    if (hearing !== (this.#hearing?.componentRef ?? null)) {
      const component = hearing === null ? null : new Hearing(this.#client, hearing);
      this.#hearing = component;
      this.#heard.from(
        component &&
          (() =>
            component.heard.subscribe((heard) => {
              if (isOwn(heard, this.visitorRef)) this.#addHeard(heard.text, heard.final);
            })),
      );
      void this.#askRecognizer(component);
    }
    if (progress !== (this.#progress?.componentRef ?? null))
      this.#progress = progress === null ? null : new SpeechProgress(this.#client, progress);
    this.#there.element.hidden = operator === null;
    this.#update();
  }

  /** @param track of the microphone; null while it is off */
  show(track: MediaStreamTrack | null): void {
    if (track === this.#track) return;
    const began = this.#track === null;
    this.#track = track;
    this.#local.follow(track);
    if (began) {
      void this.#askInterrupt();
      void this.#askRecognizer(this.#hearing);
    } else if (track === null && this.#interrupt.on) void this.#setInterrupt(false);
    this.#update();
  }

  #update(): void {
    const on = this.#switch.on && this.#hearing !== null;
    // Level events come several times a second: subscribed to only while they are shown.
    this.#level.wanted = this.#track !== null;
    this.#heard.wanted = on && this.#track !== null;
    if (this.#track === null) this.#there.show(SILENCE);
    this.#switch.element.hidden = this.#hearing === null;
    this.#interrupt.element.hidden = this.#progress === null;
    this.#list.hidden = !on;
    this.#sentTo.hidden = this.#track === null;
    if (!on) this.#sentences = [];
    this.#render("");
    this.#onChange();
  }

  #addHeard(text: string, final: boolean): void {
    if (final && text !== "") this.#sentences = [...this.#sentences, text].slice(-KEPT);
    this.#render(final ? "" : text);
  }

  #render(partial: string): void {
    const lines = this.#sentences.map((text) => make("li", {}, text));
    if (partial !== "") lines.push(make("li", { class: "partial" }, `${partial} …`));
    else if (lines.length === 0) lines.push(make("li", { class: "partial" }, "Nothing was understood yet"));
    this.#list.replaceChildren(...lines);
  }

  /** Says where the sound goes; a body that does not tell keeps it. */
  async #askRecognizer(hearing: Hearing | null): Promise<void> {
    const recognizer = (await hearing?.recognizer().catch(() => null)) ?? null;
    if (hearing !== this.#hearing) return;
    this.#recognizer = recognizer;
    this.#showSentTo();
  }

  #showSentTo(): void {
    setText(this.#sentTo, sentToWords(this.#recognizer, this.#agrees));
  }

  async #askInterrupt(): Promise<void> {
    const values = await this.#progress?.getParameter().catch(() => null);
    this.#interrupt.on = values?.barge_in === true;
  }

  async #setInterrupt(on: boolean): Promise<void> {
    const progress = this.#progress;
    if (!progress) return;
    this.#interrupt.on = on;
    setText(this.#words, "");
    try {
      await progress.bound(() => progress.setParameter({ barge_in: on }));
    } catch (error) {
      this.#interrupt.on = !on;
      this.#refused(error);
    }
  }

  #refused(error: unknown): void {
    setText(this.#words, sentence(describeFailure(error, BUSY).text));
  }
}
