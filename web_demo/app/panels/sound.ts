/** The avatar's voice. Browsers let a page sound only after its user has done something in it. */

import type { RemoteStream } from "../../sdk/media/index.ts";
import { byTestId } from "../dom/elements.ts";

export class Sound {
  readonly #audio = byTestId("avatar-audio", HTMLAudioElement);
  readonly #on = byTestId("sound-on", HTMLButtonElement);
  readonly #off = byTestId("sound-off", HTMLButtonElement);
  #stopListening: (() => void) | null = null;
  #wanted = true;
  #blocked = false;

  constructor() {
    this.#on.addEventListener("click", () => this.#set(true));
    this.#off.addEventListener("click", () => this.#set(false));
    // Any first touch of the page is permission enough.
    for (const name of ["pointerup", "keyup"] as const) {
      document.addEventListener(name, () => this.#blocked && void this.#play());
    }
  }

  /** Plays another stream; null when the avatar has no voice. */
  listen(stream: RemoteStream | null): void {
    this.#stopListening?.();
    this.#stopListening = stream?.on("track", (track) => this.#attach(track)) ?? null;
    if (stream?.track) this.#attach(stream.track);
    this.#render();
  }

  /** The user wants silence. */
  get muted(): boolean {
    return !this.#wanted;
  }

  set muted(muted: boolean) {
    this.#set(!muted);
  }

  toggle(): void {
    this.#set(this.#blocked || !this.#wanted);
  }

  #attach(track: MediaStreamTrack): void {
    this.#audio.srcObject = new MediaStream([track]);
    void this.#play();
  }

  #set(on: boolean): void {
    this.#wanted = on;
    this.#audio.muted = !on;
    if (on) void this.#play();
    // The pressed button disappears: its counterpart takes over the keyboard's focus.
    const focused = document.activeElement === this.#on || document.activeElement === this.#off;
    this.#render();
    if (focused) (this.#on.hidden ? this.#off : this.#on).focus();
  }

  async #play(): Promise<void> {
    try {
      await this.#audio.play();
      this.#blocked = false;
    } catch (error) {
      // An interrupted play() is followed by another; only a refusal needs the user.
      if (error instanceof DOMException && error.name === "NotAllowedError") this.#blocked = true;
    }
    this.#render();
  }

  #render(): void {
    const attached = this.#audio.srcObject !== null;
    const silent = this.#blocked || !this.#wanted;
    this.#on.hidden = !attached || !silent;
    this.#off.hidden = !attached || silent;
  }
}
