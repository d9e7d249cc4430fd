/** The red button: everything that acts on the avatar's engine stops. It is no safety-rated emergency stop. */

import { RoISError } from "../sdk/index.ts";
import type { Client } from "../sdk/index.ts";
import type { DeviceLease } from "./device_lease.ts";
import { byTestId, setText } from "./dom.ts";
import { explain } from "./permission.ts";

const KEY = "x";
const LABEL = "STOP";
/** Milliseconds for which it says that all has stopped; that something has not is said until it is pressed again. */
const READABLE = 4000;

export class StopButton {
  readonly #client: Client;
  readonly #lease: DeviceLease;
  readonly #button = byTestId("stop-all", HTMLButtonElement);
  readonly #title = this.#button.title;
  #engineId: string | null = null;
  #fading: ReturnType<typeof setTimeout> | undefined;

  /** @param lease is held while it stops */
  constructor(client: Client, lease: DeviceLease) {
    this.#client = client;
    this.#lease = lease;
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
    if (engineId !== this.#engineId) this.#say(LABEL);
    this.#engineId = engineId;
    this.#button.hidden = engineId === null;
  }

  /** The token does not let anything be stopped. */
  set barred(barred: boolean) {
    this.#button.disabled = barred;
    explain(this.#button, barred);
  }

  async press(): Promise<void> {
    if (this.#engineId === null || this.#button.disabled) return;
    this.#say(LABEL);
    try {
      await this.#stop(this.#engineId);
      this.#say("Stopped");
      this.#fading = setTimeout(() => this.#say(LABEL), READABLE);
    } catch (error) {
      this.#say("Not stopped", error instanceof Error ? error.message : String(error));
    }
  }

  async #stop(engineId: string): Promise<void> {
    try {
      await this.#client.control.stopAll(engineId);
    } catch (error) {
      if (!(error instanceof RoISError && error.returnCode === "OUT_OF_RESOURCES")) throw error;
      // Who stops has control of something: without any, it is taken for that moment.
      const giveBack = await this.#lease.take();
      await this.#client.control.stopAll(engineId).finally(giveBack);
    }
  }

  #say(words: string, why = this.#title): void {
    setText(this.#button, words);
    this.#button.title = why;
    clearTimeout(this.#fading);
  }
}
