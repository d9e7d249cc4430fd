/** The red button: everything that acts on the avatar's engine stops. It is no safety-rated emergency stop. */

import { RoISError } from "../../sdk/index.ts";
import type { Client } from "../../sdk/index.ts";
import { byTestId, setText, takesLetters } from "../dom/elements.ts";
import { describeFailure } from "../model/outcome.ts";
import { explain } from "../model/permission.ts";
import { sentence } from "../model/plain_words.ts";

const KEY = "x";
const LABEL = "STOP";
/** Milliseconds for which it says that all has stopped; that something has not is said until it is pressed again. */
const READABLE = 4000;

export class StopButton {
  readonly #client: Client;
  readonly #onPress: () => void;
  readonly #button = byTestId("stop-all", HTMLButtonElement);
  readonly #title = this.#button.title;
  #engineId: string | null = null;
  #acting: readonly string[] = [];
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

  /**
   * @param engineId the avatar's; null while there is none
   * @param acting its actuators, of which the page has to hold one to stop the engine
   */
  setEngine(engineId: string | null, acting: readonly string[]): void {
    this.#acting = acting;
    if (engineId !== this.#engineId) this.#say(LABEL);
    this.#engineId = engineId;
    this.#render();
  }

  /** Why nothing can be stopped; empty where it can. */
  set barred(barred: string) {
    this.#barred = barred;
    this.#render();
  }

  async press(): Promise<void> {
    if (this.#engineId === null || this.#button.disabled) return;
    this.#say(LABEL);
    const stopping = this.#stop(this.#engineId);
    this.#onPress();
    try {
      await stopping;
      this.#say("Stopped");
      this.#fading = setTimeout(() => this.#say(LABEL), READABLE);
    } catch (error) {
      this.#say("Not stopped", sentence(describeFailure(error).text));
    }
  }

  async #stop(engineId: string): Promise<void> {
    const stop = (): Promise<unknown> => this.#client.control.stopAll(engineId);
    // With a token, STOP needs a binding of an actuator: without any, a free one is bound for that moment.
    const ways = [stop, ...this.#acting.map((ref) => () => this.#client.bound(ref, stop))];
    let refused: unknown;
    for (const way of ways) {
      try {
        await way();
        return;
      } catch (error) {
        if (!(error instanceof RoISError && error.returnCode === "OUT_OF_RESOURCES")) throw error;
        refused = error;
      }
    }
    throw refused;
  }

  /** Renders the button, which is always visible at the same place. */
  #render(): void {
    this.#button.disabled = this.#engineId === null || this.#barred !== "";
    explain(this.#button, this.#barred);
  }

  #say(words: string, why = this.#title): void {
    setText(this.#button, words);
    this.#button.title = why;
    clearTimeout(this.#fading);
  }
}
