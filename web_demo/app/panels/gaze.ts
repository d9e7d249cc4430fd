/** A click on the picture makes the avatar look there; so do the arrow keys while the picture has the focus. */

import type { Client } from "../../sdk/index.ts";

/** The least milliseconds between two glances: eyes take their time, and the log should stay readable. */
const PAUSE = 300;

/** How far an arrow key turns the eyes, of a range from -1 (left, down) to 1. */
const STEPS: Readonly<Record<string, readonly [number, number]>> = {
  ArrowLeft: [-0.4, 0],
  ArrowRight: [0.4, 0],
  ArrowUp: [0, 0.4],
  ArrowDown: [0, -0.4],
};

export class Gaze {
  readonly #client: Client;
  readonly #stage: HTMLElement;
  #componentRef: string | null = null;
  #lookedAt = 0;
  #x = 0;
  #y = 0;
  /** The body was stopped while an arrow key was held down: that has to be pressed anew. */
  #halted = false;

  constructor(client: Client, stage: HTMLElement) {
    this.#client = client;
    this.#stage = stage;
    stage.addEventListener("click", (event) => {
      if (event.target instanceof Element && event.target.closest("button, .statistics") !== null) return;
      const { left, top, width, height } = stage.getBoundingClientRect();
      this.#lookAt((2 * (event.clientX - left)) / width - 1, 1 - (2 * (event.clientY - top)) / height);
    });
    stage.addEventListener("keydown", (event) => {
      const step = STEPS[event.key];
      if (!step || event.target !== stage) return;
      event.preventDefault();
      this.#halted &&= event.repeat;
      if (this.#halted) return;
      this.#lookAt(this.#x + step[0], this.#y + step[1]);
    });
    client.on("stopped", (isStopped) => (this.#halted ||= isStopped(this.#componentRef ?? "")));
  }

  setComponent(componentRef: string | null): void {
    this.#componentRef = componentRef;
    this.#stage.classList.toggle("looks", componentRef !== null);
    this.#stage.tabIndex = componentRef === null ? -1 : 0;
  }

  #lookAt(x: number, y: number): void {
    const now = performance.now();
    if (this.#componentRef === null || now - this.#lookedAt < PAUSE) return;
    this.#lookedAt = now;
    this.#x = Math.min(1, Math.max(-1, x));
    this.#y = Math.min(1, Math.max(-1, y));
    const argument = (name: string, value: number) => ({
      name,
      data_type_ref: "double",
      value: value.toFixed(3),
    });
    const unit = {
      component_ref: this.#componentRef,
      command_type: "look",
      arguments: [argument("x", this.#x), argument("y", this.#y)],
    };
    // Bound for the glance alone, unless this page has control of the body.
    void this.#client.bound(unit.component_ref, () => this.#client.execute([unit])).catch(() => undefined);
  }
}
