/** A microphone or camera of this machine: on or off, which one, and what is wrong with it. */

import type { MediaKind } from "../../sdk/index.ts";
import type { LocalStream } from "../../sdk/media/index.ts";
import { icon, make, setText } from "../dom/elements.ts";
import { deviceTrouble, deviceWords } from "../model/device_words.ts";
import type { GiveBack } from "../model/body_control.ts";
import { describeFailure } from "../model/outcome.ts";
import { explain } from "../model/permission.ts";
import { sentence } from "../model/plain_words.ts";

const NAMES: Readonly<Record<MediaKind, string>> = { audio: "microphone", video: "camera" };

const ICONS: Readonly<Record<MediaKind, readonly string[]>> = {
  audio: [
    "M12 4a2.500 2.500 0 0 1 2.500 2.500v5a2.500 2.500 0 0 1-5 0v-5A2.500 2.500 0 0 1 12 4Z",
    "M6.500 11.500a5.500 5.500 0 0 0 11 0M12 17v3",
  ],
  video: [
    "M4.500 6.500h9A1.500 1.500 0 0 1 15 8v8a1.500 1.500 0 0 1-1.500 1.500h-9A1.500 1.500 0 0 1 3 16V8a1.500 1.500 0 0 1 1.500-1.500Z",
    "M15 10.500l6-3v9l-6-3",
  ],
};

export class DeviceControl {
  readonly element: HTMLElement;
  readonly #button: HTMLButtonElement;
  readonly #state = make("span", { class: "device-state" });
  readonly #choice: HTMLSelectElement;
  readonly #trouble: HTMLElement;
  /** What is shown while the device is in use. */
  readonly #body: HTMLElement;
  readonly #onTrack: (track: MediaStreamTrack | null) => void;
  #stream: LocalStream | null = null;
  #stopListening: (() => void) | null = null;
  /** The user's answer is awaited. */
  #asking = false;
  #used = "";
  readonly #take: () => Promise<GiveBack>;
  #giveBack: GiveBack | null = null;
  /** Why it was not turned on, or is off; empty for nothing. */
  #refusal = "";
  #barred = "";

  /**
   * @param body is shown while the device is in use
   * @param take takes control, which is held meanwhile
   */
  constructor(
    kind: MediaKind,
    body: HTMLElement,
    take: () => Promise<GiveBack>,
    onTrack: (track: MediaStreamTrack | null) => void,
  ) {
    this.#take = take;
    const name = NAMES[kind];
    this.#body = body;
    this.#onTrack = onTrack;
    const label = name.charAt(0).toUpperCase() + name.slice(1);
    this.#button = make(
      "button",
      { type: "button", class: "button device-toggle", "data-testid": `${name}-toggle` },
      icon(...ICONS[kind], "M4 4l16 16"),
      label,
      this.#state,
    );
    this.#choice = make("select", { "data-testid": `${name}-device`, "aria-label": `Which ${name}` });
    this.#trouble = make("p", { class: "device-trouble", "data-testid": `${name}-trouble`, role: "alert" });
    this.element = make("div", { class: "device" }, this.#button, this.#trouble, body, this.#choice);
    this.#button.addEventListener("click", () => void this.toggle());
    this.#choice.addEventListener("change", () => void this.#stream?.use(this.#choice.value));
    navigator.mediaDevices?.addEventListener("devicechange", () => void this.#list());
    this.#render();
  }

  /** Controls another stream; null while there is no avatar to send to. */
  watch(stream: LocalStream | null): void {
    if (stream === this.#stream) return;
    this.#stopListening?.();
    void this.off();
    this.#stream = stream;
    this.#stopListening = stream?.on("change", () => this.#render()) ?? null;
    this.#render();
  }

  /** What the avatar does with it for this page, such as `looked at`; empty for nothing. */
  set used(used: string) {
    this.#used = used;
    this.#renderWords();
  }

  /** Why nothing can be sent; empty where it can. */
  set barred(barred: string) {
    if (barred === this.#barred) return;
    this.#barred = barred;
    this.#render();
  }

  /** Whether it is on, or about to be. */
  get isOn(): boolean {
    return this.#asking || this.#stream?.captured != null;
  }

  async toggle(): Promise<void> {
    const stream = this.#stream;
    if (!stream) return;
    if (stream.captured !== null || this.#asking) return this.off();
    if (this.#barred !== "") return;
    this.#asking = true;
    this.#refusal = "";
    this.#render();
    try {
      const giveBack = await this.#take();
      // Turned off and on again meanwhile, it was asked for twice.
      if (this.#isUnwanted(stream) || this.#giveBack !== null) return giveBack();
      this.#giveBack = giveBack;
      await stream.connect();
    } catch (error) {
      this.#refusal = sentence(describeFailure(error).text);
    }
    this.#asking = false;
    if (stream.desire === "disconnected") this.#giveUp();
    this.#render();
  }

  /** @param why in a sentence; empty where the user wants it so */
  async off(why = ""): Promise<void> {
    const giveBack = this.#giveBack;
    this.#giveBack = null;
    this.#asking = false;
    this.#refusal = giveBack === null ? "" : why;
    this.#render();
    try {
      await this.#stream?.disconnect();
    } finally {
      giveBack?.();
    }
  }

  /** It was turned off, or another avatar was chosen, while control was asked for. */
  #isUnwanted(stream: LocalStream): boolean {
    return !this.#asking || stream !== this.#stream;
  }

  #giveUp(): void {
    this.#giveBack?.();
    this.#giveBack = null;
  }

  #render(): void {
    const stream = this.#stream;
    const track = stream?.captured ?? null;
    const on = track !== null;
    if (on && this.#body.hidden) void this.#list();
    // What is on can always be switched off.
    this.#button.disabled = !on && (stream === null || this.#barred !== "");
    explain(this.#button, this.#barred);
    this.#button.setAttribute("aria-pressed", String(on));
    this.#renderWords();
    const trouble =
      this.#refusal || (stream && deviceTrouble(stream.captureProblem, on ? stream.problem : null));
    setText(this.#trouble, trouble || "");
    this.#trouble.hidden = !trouble;
    this.#body.hidden = !on;
    if (!on) this.#choice.hidden = true;
    this.#onTrack(track);
  }

  #renderWords(): void {
    const stream = this.#stream;
    const on = stream !== null && stream.captured !== null;
    const failed = stream?.captureProblem != null;
    const words = deviceWords(on, this.#asking, stream?.status ?? null, failed, this.#used);
    setText(this.#state, words.text);
    this.#button.dataset["state"] = words.state;
  }

  /** With one device there is nothing to choose. */
  async #list(): Promise<void> {
    const stream = this.#stream;
    const devices = (await stream?.devices()) ?? [];
    if (!stream?.captured || stream !== this.#stream) return;
    this.#choice.replaceChildren(
      ...devices.map(({ deviceId, label }, index) =>
        make("option", { value: deviceId }, label || `Number ${index + 1}`),
      ),
    );
    this.#choice.value = stream.deviceId ?? "";
    this.#choice.hidden = devices.length < 2;
  }
}
