/**
 * The red button: everything that acts on the bodies that are shown large or in a card stops. It is no safety-rated
 * emergency stop.
 */

import type { Client } from "../../sdk/index.ts";
import { byTestId, setText, takesLetters } from "../dom/elements.ts";
import { describeFailure } from "../model/outcome.ts";
import { explain } from "../model/permission.ts";
import { sentence } from "../model/plain_words.ts";
import type { ActingBody } from "../model/stopped_bodies.ts";

const KEY = "x";
const LABEL = "STOP";
/** Milliseconds for which it says that all has stopped; that something has not is said until it is pressed again. */
const READABLE = 4000;

export class StopButton {
  readonly #client: Client;
  readonly #onPress: () => void;
  readonly #button = byTestId("stop-all", HTMLButtonElement);
  readonly #title = this.#button.title;
  #bodies: readonly ActingBody[] = [];
  #barred = "";
  #fading: ReturnType<typeof setTimeout> | undefined;

  /** @param onPress clears what this page would let the avatar do next */
  constructor(client: Client, onPress: () => void) {
    this.#client = client;
    this.#onPress = onPress;
    this.#button.addEventListener("click", () => void this.press());
    // Before anything else on the page can keep the key to itself.
    document.addEventListener("keydown", (event) => this.#keyDown(event), { capture: true });
  }

  #keyDown(event: KeyboardEvent): void {
    const { key, ctrlKey, metaKey, altKey, repeat } = event;
    if (key.toLowerCase() !== KEY || ctrlKey || metaKey || altKey || repeat) return;
    if (takesLetters(event.target)) return;
    // A list would choose what begins with this letter.
    event.preventDefault();
    event.stopPropagation();
    void this.press();
  }

  /** @param bodies those that are there, the one that is shown large first */
  setBodies(bodies: readonly ActingBody[]): void {
    if (bodies[0]?.engineId !== this.#bodies[0]?.engineId) this.#say(LABEL);
    this.#bodies = bodies;
    this.#render();
  }

  /** Why nothing can be stopped; empty where it can. */
  set barred(barred: string) {
    this.#barred = barred;
    this.#render();
  }

  async press(): Promise<void> {
    if (this.#bodies.length === 0 || this.#button.disabled) return;
    this.#say(LABEL);
    // Each is told at once: one that cannot be stopped holds up no other.
    const stopping = this.#bodies.map(({ engineId }) => this.#client.control.stopAll(engineId));
    this.#onPress();
    const ends = await Promise.allSettled(stopping);
    const failed = ends.find((end) => end.status === "rejected");
    if (failed) return this.#say("Not stopped", sentence(describeFailure(failed.reason).text));
    this.#say("Stopped");
    this.#fading = setTimeout(() => this.#say(LABEL), READABLE);
  }

  /** Renders the button, which is always visible at the same place. */
  #render(): void {
    this.#button.disabled = this.#bodies.length === 0 || this.#barred !== "";
    explain(this.#button, this.#barred);
  }

  #say(words: string, why = this.#title): void {
    setText(this.#button, words);
    this.#button.title = why;
    clearTimeout(this.#fading);
  }
}
