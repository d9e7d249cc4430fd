/** A stick on the screen, for fingers: it walks and turns the avatar like the left stick of a gamepad. */

import { byTestId } from "../dom/elements.ts";

/** Where the knob stands: x from -1 (left) to 1, y from -1 (up) to 1, within a circle. Pure. */
export function deflection(dx: number, dy: number, radius: number): readonly [number, number] {
  const size = Math.max(radius, Math.hypot(dx, dy)) || 1;
  return [dx / size, dy / size];
}

export class Stick {
  readonly #element: HTMLElement;
  readonly #onMove: (x: number, y: number) => void;
  #pointerId: number | null = null;

  /**
   * @param onMove is called with its position; 0, 0 when it is released
   * @param root what it is part of
   */
  constructor(onMove: (x: number, y: number) => void, root: ParentNode) {
    this.#onMove = onMove;
    const element = byTestId("stick", HTMLElement, root);
    this.#element = element;
    element.addEventListener("pointerdown", (event) => {
      event.preventDefault();
      if (this.#pointerId !== null) return;
      this.#pointerId = event.pointerId;
      element.setPointerCapture(event.pointerId);
      this.#move(event);
    });
    // The picture keeps the focus, which driving needs.
    element.addEventListener("mousedown", (event) => event.preventDefault());
    element.addEventListener("pointermove", (event) => this.#move(event));
    for (const name of ["pointerup", "pointercancel", "lostpointercapture"] as const)
      element.addEventListener(name, ({ pointerId }) => {
        if (pointerId === this.#pointerId) this.#letGo();
      });
  }

  /** Whether it can be used now. */
  set shown(shown: boolean) {
    this.#element.hidden = !shown;
    if (!shown && this.#pointerId !== null) this.#letGo();
  }

  #move({ pointerId, clientX, clientY }: PointerEvent): void {
    if (pointerId !== this.#pointerId) return;
    const { left, top, width, height } = this.#element.getBoundingClientRect();
    // The knob is as wide as the way that it can go to either side.
    const radius = width / 3;
    this.#put(...deflection(clientX - left - width / 2, clientY - top - height / 2, radius));
  }

  #letGo(): void {
    this.#pointerId = null;
    this.#put(0, 0);
  }

  #put(x: number, y: number): void {
    this.#element.style.setProperty("--x", x.toFixed(3));
    this.#element.style.setProperty("--y", y.toFixed(3));
    this.#onMove(x, y);
  }
}
