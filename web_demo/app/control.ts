/** Driving the avatar by hand: keyboard, mouse, fingers and gamepad, from "Take control" on. */

import { RoISError } from "../sdk/index.ts";
import type { Client } from "../sdk/index.ts";
import { Teleoperation } from "../sdk/media/index.ts";
import type { InputMedia } from "../sdk/media/index.ts";
import { byTestId, setText } from "./dom.ts";

const HOW = "You drive: W A S D or a gamepad goes, the mouse looks, Escape lets go";
const BUSY = "Somebody else drives this avatar";
/** Milliseconds for which a sentence stands. */
const READABLE = 5000;

export class Control {
  readonly #client: Client;
  readonly #media: InputMedia;
  readonly #picture: HTMLElement;
  readonly #button = byTestId("control-toggle", HTMLButtonElement);
  readonly #words = byTestId("control-words", HTMLElement);
  #teleoperation: Teleoperation | null = null;
  #fading: ReturnType<typeof setTimeout> | undefined;
  #detach: (() => void) | null = null;

  /** @param picture has the focus meanwhile */
  constructor(client: Client, media: InputMedia, picture: HTMLElement) {
    this.#client = client;
    this.#media = media;
    this.#picture = picture;
    this.#button.addEventListener("click", () => void this.toggle());
    picture.addEventListener("keydown", (event) => {
      if (event.key === "Escape" && this.#detach) void this.toggle();
    });
  }

  /** @param componentRef the Teleoperation component; null when the avatar has none or is away */
  setComponent(componentRef: string | null): void {
    this.#button.hidden = componentRef === null;
    if (componentRef === null || this.#teleoperation?.componentRef === componentRef) return;
    this.#detach?.();
    const teleoperation = new Teleoperation(this.#client, this.#media, componentRef);
    this.#teleoperation = teleoperation;
    for (const name of ["refused", "stopped", "ended"] as const)
      teleoperation.on(name, (reason) => this.#say(reason));
    teleoperation.on("ended", () => this.#show(false));
  }

  async toggle(): Promise<void> {
    const teleoperation = this.#teleoperation;
    if (!teleoperation) return;
    try {
      if (this.#detach) {
        this.#show(false);
        await teleoperation.stop();
        return;
      }
      await teleoperation.start();
      this.#show(teleoperation.operating);
    } catch (error) {
      const busy = error instanceof RoISError && error.returnCode === "OUT_OF_RESOURCES";
      this.#say(busy ? BUSY : error instanceof Error ? error.message : String(error));
    }
  }

  #show(operating: boolean): void {
    this.#detach?.();
    // Reactions are a component of their own, and stay on the page's keys.
    const options = { pageKeys: (code: string) => code.startsWith("Digit") };
    this.#detach = operating ? (this.#teleoperation?.attach(this.#picture, options) ?? null) : null;
    this.#button.setAttribute("aria-pressed", String(operating));
    this.#picture.tabIndex = operating ? 0 : -1;
    if (!operating) return;
    this.#picture.focus({ preventScroll: true });
    this.#say(HOW);
  }

  #say(words: string): void {
    setText(this.#words, words);
    this.#words.hidden = false;
    clearTimeout(this.#fading);
    this.#fading = setTimeout(() => (this.#words.hidden = true), READABLE);
  }
}
