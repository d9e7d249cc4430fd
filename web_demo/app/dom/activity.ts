/** Whether the visitor uses the page: keys, pointer, touch, and gamepads, which send no events. */

const EVENTS = ["keydown", "pointerdown", "pointermove", "touchmove", "wheel"];

export class Activity {
  #lastAt = performance.now();
  /** Of each gamepad, when something of it has changed last. */
  #pads = "";

  constructor(root: EventTarget) {
    const note = (): void => void (this.#lastAt = performance.now());
    for (const name of EVENTS) root.addEventListener(name, note, { capture: true, passive: true });
  }

  /** Whether the page was used within so many milliseconds; of a gamepad, since this was asked last. */
  within(milliseconds: number): boolean {
    const pads = (navigator.getGamepads?.() ?? []).map((pad) => pad?.timestamp ?? 0).join();
    if (pads !== this.#pads) this.#lastAt = performance.now();
    this.#pads = pads;
    return document.visibilityState === "visible" && performance.now() - this.#lastAt <= milliseconds;
  }
}
