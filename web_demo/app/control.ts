/** Driving the avatar by hand: keyboard, mouse, fingers and gamepad, from "Take control" on. */

import { RoISError, onlyComponent, resultValue } from "../sdk/index.ts";
import type { Client } from "../sdk/index.ts";
import { Teleoperation } from "../sdk/media/index.ts";
import type { InputMedia } from "../sdk/media/index.ts";
import { byTestId, make, setText } from "./dom.ts";
import { GamepadWatch } from "./gamepad.ts";
import type { Pad } from "./gamepad.ts";
import { explain } from "./permission.ts";

const BUSY = "Somebody else drives this avatar";
const KEYS: readonly (readonly [string, string])[] = [
  ["W S, ↑ ↓", "ahead and back"],
  ["A D, ← →", "turn"],
  ["Q E", "step aside"],
  ["Mouse", "look"],
  ["Escape", "let go"],
];
const PAD: readonly (readonly [string, string])[] = [
  ["Left stick", "go and turn"],
  ["D-pad", "go and turn"],
  ["L1 R1", "step aside"],
  ["Right stick", "look"],
];
/** Milliseconds for which a sentence stands, and the list of what does what. */
const READABLE = 5000;
const LEGEND = 8000;

export class Control {
  readonly #client: Client;
  readonly #media: InputMedia;
  readonly #picture: HTMLElement;
  readonly #button = byTestId("control-toggle", HTMLButtonElement);
  readonly #words = byTestId("control-words", HTMLElement);
  readonly #legend = byTestId("control-legend", HTMLElement);
  readonly #pads: GamepadWatch;
  #teleoperation: Teleoperation | null = null;
  #fading: ReturnType<typeof setTimeout> | undefined;
  #closing: ReturnType<typeof setTimeout> | undefined;
  #detach: (() => void) | null = null;

  /** @param picture has the focus meanwhile */
  constructor(client: Client, media: InputMedia, picture: HTMLElement) {
    this.#client = client;
    this.#media = media;
    this.#picture = picture;
    this.#pads = new GamepadWatch((pad) => void this.#padChanged(pad));
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
    if (this.#pads.pad) void this.#padChanged(this.#pads.pad);
  }

  /** The token does not let the avatar be driven. */
  set barred(barred: boolean) {
    this.#button.disabled = barred;
    explain(this.#button, barred);
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
    this.#detach = operating ? (this.#teleoperation?.attach(this.#picture) ?? null) : null;
    this.#button.setAttribute("aria-pressed", String(operating));
    this.#picture.tabIndex = operating ? 0 : -1;
    this.#showLegend();
    if (!operating) return this.#rest();
    this.#picture.focus({ preventScroll: true });
    this.#rest();
  }

  /** What does what is shown for a while, anew when there is another gamepad. */
  #showLegend(): void {
    clearTimeout(this.#closing);
    this.#legend.hidden = this.#detach === null;
    if (this.#detach === null) return;
    const rows = this.#pads.pad?.standard ? [...PAD, ...KEYS.slice(-1)] : KEYS;
    this.#legend.replaceChildren(
      ...rows.flatMap(([what, does]) => [make("dt", {}, what), make("dd", {}, does)]),
    );
    this.#closing = setTimeout(() => (this.#legend.hidden = true), LEGEND);
  }

  async #padChanged(pad: Pad | null): Promise<void> {
    this.#button.classList.toggle("ready", pad?.standard === true);
    if (this.#detach) {
      this.#showLegend();
      return this.#rest();
    }
    if (pad === null || this.#teleoperation === null) return this.#rest();
    if (!pad.standard)
      return this.#say(`${pad.name} has another mapping than the standard's: it cannot drive`);
    const taken = await this.#isOperated(this.#teleoperation.componentRef);
    this.#say(
      taken
        ? `${pad.name} is connected; somebody else drives`
        : `${pad.name} is connected: take control to drive`,
    );
  }

  async #isOperated(componentRef: string): Promise<boolean> {
    const results = await this.#client.query("operation", onlyComponent(componentRef)).catch(() => []);
    return resultValue(results, "operated") === "true";
  }

  /** What is said for as long as nothing happens. */
  #rest(): void {
    clearTimeout(this.#fading);
    this.#words.hidden = this.#detach === null;
    const pad = this.#pads.pad?.standard ? ` with ${this.#pads.pad.name}` : "";
    if (this.#detach) setText(this.#words, `You drive${pad}`);
  }

  #say(words: string): void {
    setText(this.#words, words);
    this.#words.hidden = false;
    clearTimeout(this.#fading);
    this.#fading = setTimeout(() => this.#rest(), READABLE);
  }
}
