/** A click on the picture makes the avatar look there. */

import type { RoISClient } from "../sdk/index.ts";

/** The least milliseconds between two glances: eyes take their time, and the log should stay readable. */
const PAUSE = 300;

export class Gaze {
  readonly #client: RoISClient;
  readonly #stage: HTMLElement;
  #componentRef: string | null = null;
  #lookedAt = 0;

  constructor(client: RoISClient, stage: HTMLElement) {
    this.#client = client;
    this.#stage = stage;
    stage.addEventListener("click", (event) => {
      if (!(event.target instanceof Element) || event.target.closest("button") === null) this.#look(event);
    });
  }

  setComponent(componentRef: string | null): void {
    this.#componentRef = componentRef;
    this.#stage.classList.toggle("looks", componentRef !== null);
  }

  #look({ clientX, clientY, timeStamp }: MouseEvent): void {
    if (this.#componentRef === null || timeStamp - this.#lookedAt < PAUSE) return;
    this.#lookedAt = timeStamp;
    const { left, top, width, height } = this.#stage.getBoundingClientRect();
    const argument = (name: string, value: number) => ({
      name,
      data_type_ref: "double",
      value: value.toFixed(3),
    });
    const x = (2 * (clientX - left)) / width - 1;
    const y = 1 - (2 * (clientY - top)) / height;
    const unit = {
      component_ref: this.#componentRef,
      command_type: "look",
      arguments: [argument("x", x), argument("y", y)],
    };
    void this.#client.execute([unit]).catch(() => undefined);
  }
}
