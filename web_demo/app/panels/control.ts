/** Teleoperation from "Take control" on: keyboard, mouse, touch and gamepad. */

import type { Client } from "../../sdk/index.ts";
import { Teleoperation } from "../../sdk/media/index.ts";
import type { InputMedia } from "../../sdk/media/index.ts";
import type { BodyControl, GiveBack } from "../model/body_control.ts";
import { byTestId, make, setText } from "../dom/elements.ts";
import { GamepadWatch } from "./gamepad.ts";
import type { Pad } from "./gamepad.ts";
import { describeFailure } from "../model/outcome.ts";
import { explain } from "../model/permission.ts";
import { amid, plainReason, sentence } from "../model/plain_words.ts";
import { Stick } from "./stick.ts";

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
const TOUCH: readonly (readonly [string, string])[] = [
  ["Stick", "walk"],
  ["Drag", "look"],
];
/** Milliseconds for which a sentence stands, and the list of what does what. */
const READABLE = 5000;
const LEGEND = 8000;

export class Control {
  readonly #client: Client;
  readonly #media: InputMedia;
  readonly #body: BodyControl;
  readonly #picture: HTMLElement;
  readonly #button: HTMLButtonElement;
  readonly #words: HTMLElement;
  readonly #legend: HTMLElement;
  readonly #pads: GamepadWatch;
  readonly #stick: Stick;
  /** Whether the page is operated by touch. */
  readonly #fingers = matchMedia("(any-pointer: coarse)");
  #teleoperation: Teleoperation | null = null;
  #fading: ReturnType<typeof setTimeout> | undefined;
  #closing: ReturnType<typeof setTimeout> | undefined;
  #detach: (() => void) | null = null;
  #giveBack: GiveBack | null = null;

  /**
   * @param body is held while the avatar is driven
   * @param picture has the focus meanwhile
   * @param root what button, words and stick are part of
   */
  constructor(client: Client, media: InputMedia, body: BodyControl, picture: HTMLElement, root: ParentNode) {
    this.#button = byTestId("control-toggle", HTMLButtonElement, root);
    this.#words = byTestId("control-words", HTMLElement, root);
    this.#legend = byTestId("control-legend", HTMLElement, root);
    this.#stick = new Stick((x, y) => this.#teleoperation?.stick(x, y), root);
    this.#client = client;
    this.#media = media;
    this.#body = body;
    this.#picture = picture;
    this.#pads = new GamepadWatch((pad) => this.#padChanged(pad));
    this.#button.addEventListener("click", () => void this.toggle());
    picture.addEventListener("keydown", (event) => {
      if (event.key === "Escape" && this.#detach) void this.toggle();
    });
  }

  /** @param componentRef the Teleoperation component; null when the avatar has none or is away */
  setComponent(componentRef: string | null): void {
    this.#button.hidden = componentRef === null;
    if (componentRef === null || this.#teleoperation?.componentRef === componentRef) return;
    this.#show(false);
    const teleoperation = new Teleoperation(this.#client, this.#media, componentRef);
    this.#teleoperation = teleoperation;
    for (const name of ["refused", "stopped", "paced"] as const)
      teleoperation.on(name, (reason) => {
        // What is still on its way when control has ended is refused, too: that says nothing new.
        if (this.#detach) this.#say(sentence(plainReason(reason)));
      });
    teleoperation.on("ended", (reason) => {
      if (teleoperation === this.#teleoperation) this.#drivingEnded(sentence(plainReason(reason)));
    });
    if (this.#pads.pad) this.#padChanged(this.#pads.pad);
  }

  /** Why the avatar cannot be driven; empty where it can. */
  set barred(barred: string) {
    this.#button.disabled = barred !== "";
    explain(this.#button, barred);
  }

  async toggle(): Promise<void> {
    const teleoperation = this.#teleoperation;
    if (!teleoperation || this.#button.getAttribute("aria-busy") === "true") return;
    try {
      if (!this.#detach) return await this.#start(teleoperation, await this.#takeControl());
      const giveBack = this.#giveBack;
      this.#giveBack = null;
      this.#show(false);
      await teleoperation.stop().finally(() => giveBack?.());
    } catch (error) {
      this.#say(sentence(describeFailure(error).text));
    }
  }

  /** Begins to drive with what was granted; returns false where the avatar cannot be driven. */
  drive(giveBack: GiveBack): boolean {
    const teleoperation = this.#teleoperation;
    if (!teleoperation) return false;
    this.#start(teleoperation, giveBack).catch((error: unknown) =>
      this.#say(sentence(describeFailure(error).text)),
    );
    return true;
  }

  /** Takes control; the button is busy meanwhile. */
  async #takeControl(): Promise<GiveBack> {
    this.#button.setAttribute("aria-busy", "true");
    try {
      return await this.#body.takeControl();
    } finally {
      this.#button.removeAttribute("aria-busy");
    }
  }

  /** The body was handed over, or lost. @param why in a sentence, whatever the end of driving said before */
  controlLost(why: string): void {
    this.#drivingEnded("");
    this.#say(why);
  }

  /** The avatar is not driven any more, though this page did not end it. @param why in a sentence; empty for no words */
  #drivingEnded(why: string): void {
    const was = this.#detach !== null;
    const giveBack = this.#giveBack;
    this.#giveBack = null;
    this.#show(false);
    giveBack?.();
    if (was && why !== "") this.#say(why);
  }

  async #start(teleoperation: Teleoperation, giveBack: GiveBack): Promise<void> {
    this.#button.setAttribute("aria-busy", "true");
    try {
      await teleoperation.start();
    } catch (error) {
      giveBack();
      throw error;
    } finally {
      this.#button.removeAttribute("aria-busy");
    }
    // It may have been granted while it was being taken.
    if (this.#giveBack !== null) return giveBack();
    if (!teleoperation.operating || this.#body.state.kind !== "mine") return giveBack();
    this.#giveBack = giveBack;
    this.#show(true);
  }

  #show(operating: boolean): void {
    this.#detach?.();
    this.#detach = operating ? (this.#teleoperation?.attach(this.#picture) ?? null) : null;
    this.#button.setAttribute("aria-pressed", String(operating));
    this.#picture.tabIndex = operating ? 0 : -1;
    this.#picture.classList.toggle("driven", operating);
    this.#stick.shown = operating && this.#fingers.matches;
    this.#showLegend();
    if (!operating) return this.#rest();
    this.#picture.focus({ preventScroll: true });
    this.#rest();
  }

  /** Shows the legend of keys for a while, and again for another gamepad. */
  #showLegend(): void {
    clearTimeout(this.#closing);
    this.#legend.hidden = this.#detach === null;
    if (this.#detach === null) return;
    const keys = matchMedia("(pointer: coarse)").matches ? TOUCH : KEYS;
    const rows = this.#pads.pad?.standard ? [...PAD, ...keys.slice(-1)] : keys;
    this.#legend.replaceChildren(
      ...rows.flatMap(([what, does]) => [make("dt", {}, what), make("dd", {}, does)]),
    );
    this.#closing = setTimeout(() => (this.#legend.hidden = true), LEGEND);
  }

  #padChanged(pad: Pad | null): void {
    this.#button.classList.toggle("ready", pad?.standard === true);
    if (this.#detach) {
      this.#showLegend();
      return this.#rest();
    }
    if (pad === null || this.#teleoperation === null) return this.#rest();
    if (!pad.standard)
      return this.#say(
        `${pad.name} cannot drive: the browser does not know its buttons. Use another one, or the keyboard.`,
      );
    const holder = this.#body.holderOf(this.#teleoperation.componentRef);
    const then = holder === "" ? ": take control to drive" : `; ${amid(holder)} has control`;
    this.#say(`${pad.name} is connected${then}`);
  }

  /** Shows the text for the normal state. */
  #rest(): void {
    clearTimeout(this.#fading);
    this.#words.hidden = this.#detach === null;
    const pad = this.#pads.pad?.standard ? `, with ${this.#pads.pad.name}` : "";
    if (this.#detach) setText(this.#words, `You have control${pad}`);
  }

  #say(words: string): void {
    setText(this.#words, words);
    this.#words.hidden = false;
    clearTimeout(this.#fading);
    this.#fading = setTimeout(() => this.#rest(), READABLE);
  }
}
