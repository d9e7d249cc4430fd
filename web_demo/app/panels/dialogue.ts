/** Card of the dialogue: what was said and heard, what can be said, where words go, and a button to talk. */

import type { Client, Purpose, Subscription } from "../../sdk/index.ts";
import { byRole, byTestId, make, setText } from "../dom/elements.ts";
import type { PageBody } from "../model/bodies.ts";
import { DialogueLines, visitorName } from "../model/dialogue.ts";
import type { DialogueLine } from "../model/dialogue.ts";
import { Dialogue, Hearing, SpeechProgress } from "../model/own_components.ts";
import type { Conversing } from "../model/own_components.ts";
import { explain } from "../model/permission.ts";
import { wordsSentToWords } from "../model/sent_to.ts";
import { Talking } from "../model/talking.ts";
import type { Microphone } from "../model/talking.ts";
import { Wanted } from "../senses/wanted.ts";

/** The list follows its end while it is scrolled this close to it, in pixels. */
const NEAR_END = 40;
const NOT_CONVERSING: Conversing = { sent_to: "", can_be_said: [], wake_word: "" };

/** What the card asks of the rest of the page. */
export interface DialogueParts {
  microphone(): (Microphone & { readonly stream: { readonly status: string | null } }) | null;
  /** Why the microphone cannot be switched on; empty where it can. */
  microphoneBarred(): string;
  /** The visitor that this page is; empty while that is not known. */
  visitorRef(): string;
  /** The purposes that are not consented to, of these. */
  missing(purposes: readonly Purpose[]): Purpose[];
  consentTo(purposes: readonly Purpose[]): void;
  /** Names the one that speaks through the body now. */
  speaker(): string;
}

export class DialogueCard {
  readonly #client: Client;
  readonly #parts: DialogueParts;
  readonly #card = byTestId("dialogue", HTMLElement);
  readonly #log = byTestId("dialogue-lines", HTMLElement);
  readonly #list = byRole("dialogue-list", HTMLElement);
  readonly #sentTo = byTestId("dialogue-sent-to", HTMLElement);
  readonly #agree = byTestId("dialogue-agree", HTMLElement);
  readonly #agreeWords = byTestId("dialogue-agree-words", HTMLElement);
  readonly #talk = byTestId("talk", HTMLButtonElement);
  readonly #wake = byTestId("dialogue-wake", HTMLElement);
  readonly #examples = byTestId("dialogue-examples", HTMLElement);
  readonly #canBeSaid = byTestId("dialogue-can-be-said", HTMLElement);
  readonly #lines = new DialogueLines();
  readonly #talking: Talking;
  readonly #heard = new Wanted();
  readonly #said: readonly Wanted[] = [new Wanted(), new Wanted()];
  readonly #changed = new Wanted();
  #engineId = "";
  #refs = "";
  #conversing = NOT_CONVERSING;
  #shown: readonly DialogueLine[] = [];
  readonly #rows = new Map<DialogueLine, HTMLElement>();

  constructor(client: Client, parts: DialogueParts) {
    this.#client = client;
    this.#parts = parts;
    this.#talking = new Talking(
      () => parts.microphone(),
      () => this.render(),
    );
    byTestId("dialogue-agree-button", HTMLButtonElement).addEventListener("click", () => {
      parts.consentTo(this.#missing);
      this.render();
      this.#talk.focus();
    });
    this.#listenToButton();
    for (const each of [this.#changed, ...this.#said]) each.wanted = true;
  }

  /** @param body the one that is shown; null while it is away, or there is no connection */
  setBody(body: PageBody | null): void {
    if (body === null) {
      this.#talking.end();
      return this.render();
    }
    const { engineId, hearing, progress, dialogue } = body;
    if (engineId !== this.#engineId) {
      this.#talking.end();
      this.#lines.clear();
      this.#engineId = engineId;
    }
    this.#card.hidden = progress === null && dialogue === null;
    const refs = [hearing, progress, dialogue].join();
    if (refs !== this.#refs) {
      this.#refs = refs;
      this.#follow(hearing, progress, dialogue);
    }
    this.render();
  }

  /** Shows how things stand now. */
  render(): void {
    const { sent_to, can_be_said, wake_word } = this.#conversing;
    const converses = sent_to !== "" || can_be_said.length > 0 || wake_word !== "";
    const microphone = this.#parts.microphone();
    // Sound is recognised for those who ask for words: of a program that converses that is so anyway.
    this.#heard.wanted = converses || this.#talking.talks;
    const missing = converses && microphone !== null ? this.#missing : [];
    const leaves = wordsSentToWords(sent_to, missing.length === 0);
    setText(this.#sentTo, leaves);
    this.#sentTo.hidden = leaves === "";
    setText(this.#agreeWords, agreeWords(missing));
    this.#agree.hidden = missing.length === 0;
    setText(this.#wake, wake_word && `Begin with “${wake_word}”, with your microphone on.`);
    this.#wake.hidden = wake_word === "";
    this.#renderTalk(microphone, wake_word !== "");
    this.#examples.hidden = can_be_said.length === 0;
    const items = [...this.#canBeSaid.children].map(({ textContent }) => textContent);
    if (items.join("\n") !== can_be_said.join("\n"))
      this.#canBeSaid.replaceChildren(...can_be_said.map((text) => make("li", {}, text)));
    this.#renderLines();
  }

  /** The purposes without which a program that answers gets no words. */
  get #missing(): Purpose[] {
    const sent: Purpose[] = this.#conversing.sent_to === "" ? [] : ["transfer"];
    return this.#parts.missing(["recognition", "agent", ...sent]);
  }

  #renderTalk(microphone: ReturnType<DialogueParts["microphone"]>, wakes: boolean): void {
    const { held } = this.#talking;
    const barred = this.#parts.microphoneBarred();
    this.#talk.hidden = microphone === null || wakes;
    this.#talk.disabled = !held && barred !== "";
    explain(this.#talk, barred);
    this.#talk.setAttribute("aria-pressed", String(held));
    const isSent = microphone?.stream.status === "STREAMING_RUNNING";
    this.#talk.dataset["state"] = !held ? "off" : isSent ? "on" : "waiting";
    setText(this.#talk, !held ? "Hold to talk" : isSent ? "Speak now" : "Connecting …");
  }

  #renderLines(): void {
    const lines = this.#lines.all;
    if (lines === this.#shown) return;
    this.#shown = lines;
    const { scrollHeight, scrollTop, clientHeight } = this.#log;
    const follows = scrollHeight - scrollTop - clientHeight < NEAR_END;
    // Lines that stay are left alone, so that screen readers read only what is new.
    for (const [line, element] of this.#rows) {
      if (lines.includes(line)) continue;
      element.remove();
      this.#rows.delete(line);
    }
    lines.forEach((line, index) => {
      if (this.#rows.has(line)) return;
      const element = row(line);
      this.#rows.set(line, element);
      this.#list.insertBefore(element, this.#list.children[index] ?? null);
    });
    if (follows) this.#log.scrollTop = this.#log.scrollHeight;
  }

  #follow(hearing: string | null, progress: string | null, dialogue: string | null): void {
    const client = this.#client;
    const ears = hearing === null ? null : new Hearing(client, hearing);
    this.#heard.from(
      ears &&
        (() =>
          ears.heard.subscribe(({ text, final, visitor_ref }) => {
            if (final)
              this.#add(() => this.#lines.heard(text, visitorName(visitor_ref, this.#parts.visitorRef())));
          })),
    );
    const voice = progress === null ? null : new SpeechProgress(client, progress);
    const [began, ended] = this.#said;
    began?.from(
      voice &&
        (() =>
          voice.speechBegan.subscribe((speech) =>
            this.#add(() => this.#lines.began(speech, this.#parts.speaker())),
          )),
    );
    ended?.from(
      voice && (() => voice.speechEnded.subscribe((speech) => this.#add(() => this.#lines.ended(speech)))),
    );
    const component = dialogue === null ? null : new Dialogue(client, dialogue);
    this.#conversing = NOT_CONVERSING;
    this.#changed.from(component && (() => this.#watch(component)));
  }

  /** Reads what holds behind the subscription: nothing is missed between the two. */
  async #watch(component: Dialogue): Promise<Subscription> {
    const subscription = await component.changed.subscribe((now) => this.#converse(now));
    const now = await component.getParameter().catch(() => ({}));
    this.#converse({ ...NOT_CONVERSING, ...now });
    return subscription;
  }

  #converse(now: Conversing): void {
    this.#conversing = now;
    this.render();
  }

  #add(change: () => void): void {
    change();
    this.#renderLines();
  }

  #listenToButton(): void {
    const button = this.#talk;
    const isKey = ({ key }: KeyboardEvent): boolean => key === " " || key === "Enter";
    button.addEventListener("pointerdown", (event) => {
      if (event.button !== 0 || button.disabled) return;
      button.setPointerCapture(event.pointerId);
      this.#talking.press();
    });
    for (const name of ["pointerup", "pointercancel", "lostpointercapture", "blur"])
      button.addEventListener(name, () => this.#talking.release());
    button.addEventListener("contextmenu", (event) => event.preventDefault());
    button.addEventListener("keydown", (event) => {
      if (!isKey(event)) return;
      event.preventDefault();
      if (!event.repeat) this.#talking.press();
    });
    button.addEventListener("keyup", (event) => {
      if (isKey(event)) this.#talking.release();
    });
    globalThis.addEventListener("blur", () => this.#talking.release());
    document.addEventListener("visibilitychange", () => {
      if (document.visibilityState !== "visible") this.#talking.end();
    });
  }
}

function agreeWords(missing: readonly Purpose[]): string {
  const what: Partial<Record<Purpose, string>> = {
    recognition: "recognise your words",
    agent: "pass them to the program that answers",
    transfer: "send them to that machine",
  };
  const words = missing.flatMap((purpose) => what[purpose] ?? []);
  const last = words.pop();
  if (last === undefined) return "";
  return `To be answered, let the body ${words.length > 0 ? `${words.join(", ")} and ${last}` : last}.`;
}

function row({ kind, by, text, cut }: DialogueLine): HTMLLIElement {
  const words = make("p", {}, text);
  if (cut !== null) {
    const heard = cut === "" ? "interrupted before a word was heard" : `interrupted; heard: “${cut}”`;
    words.append(make("span", { class: "cut" }, heard));
  }
  return make("li", { "data-kind": kind }, make("span", { class: "by" }, by), words);
}
