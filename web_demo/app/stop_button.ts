/** The red button: everything that acts on the avatar's engine stops. It is no safety-rated emergency stop. */

import type { Client } from "../sdk/index.ts";
import { byTestId, setText } from "./dom.ts";

const KEY = "x";
/** Milliseconds for which it says how it went. */
const READABLE = 4000;

export class StopButton {
  readonly #client: Client;
  readonly #button = byTestId("stop-all", HTMLButtonElement);
  readonly #title = this.#button.title;
  #engineId: string | null = null;
  #fading: ReturnType<typeof setTimeout> | undefined;

  constructor(client: Client) {
    this.#client = client;
    this.#button.addEventListener("click", () => void this.press());
    // Before anything else on the page can keep the key to itself.
    document.addEventListener("keydown", (event) => this.#keyDown(event), { capture: true });
  }

  #keyDown(event: KeyboardEvent): void {
    const typed = event.target instanceof HTMLElement && event.target.matches("input, textarea, select");
    if (event.key !== KEY || typed || event.ctrlKey || event.metaKey || event.altKey || event.repeat) return;
    event.stopPropagation();
    void this.press();
  }

  /** @param engineId the avatar's; null while there is none */
  setEngine(engineId: string | null): void {
    this.#engineId = engineId;
    this.#button.hidden = engineId === null;
  }

  async press(): Promise<void> {
    if (this.#engineId === null) return;
    try {
      await this.#client.control.stopAll(this.#engineId);
      this.#say("Stopped", "");
    } catch (error) {
      this.#say("Not stopped", error instanceof Error ? error.message : String(error));
    }
  }

  #say(words: string, why: string): void {
    setText(this.#button, words);
    this.#button.title = why || this.#title;
    clearTimeout(this.#fading);
    this.#fading = setTimeout(() => setText(this.#button, "STOP"), READABLE);
  }
}
