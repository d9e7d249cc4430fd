/** Collects the operator's input at an element of the page: keyboard, mouse, fingers and gamepad. */

import type { Held } from "./held.ts";
import type { Change, Why } from "./messages.ts";

export interface CollectorOptions {
  /** A click captures the mouse until Escape is pressed: it moves without an end, and its movements count. */
  readonly pointerLock?: boolean;
  /** Whether a key (`KeyboardEvent.code`) stays the page's own. */
  readonly pageKeys?: (code: string) => boolean;
}

export interface CollectorEvents {
  /** Is called for a change that has to be sent at once. */
  onChange(change: Change): void;
  /** Is called when a pointer, finger or stick moved. */
  onMove(): void;
  /** Is called when everything is released. */
  onRelease(why: Why): void;
}

/** The part of a gamepad that is read. */
type Pad = Pick<Gamepad, "axes" | "buttons" | "mapping" | "connected">;

/** Keys that the page and the browser need themselves. */
const NOT_OURS = new Set(["Tab", "Escape", "F5", "F11", "F12"]);

/** Collects input until `detach`. Keys count while the element has the focus, which a click gives it. */
export class Collector {
  readonly #element: HTMLElement;
  readonly #held: Held;
  readonly #events: CollectorEvents;
  readonly #options: CollectorOptions;
  readonly #ends: (() => void)[] = [];
  /** Where a captured mouse points to. */
  #at: [number, number] = [0.5, 0.5];

  constructor(element: HTMLElement, held: Held, events: CollectorEvents, options: CollectorOptions = {}) {
    this.#element = element;
    this.#held = held;
    this.#events = events;
    this.#options = options;
    if (element.tabIndex < 0) element.tabIndex = 0;
    this.#listenToKeys();
    this.#listenToPointer();
    this.#on(element, "blur", () => this.#events.onRelease("blur"));
    this.#on(window, "blur", () => this.#events.onRelease("blur"));
    this.#on(window, "pagehide", () => this.#events.onRelease("hidden"));
    this.#on(document, "visibilitychange", () => {
      if (document.visibilityState === "hidden") this.#events.onRelease("hidden");
    });
  }

  /** Reads the gamepad; to be called often, since gamepads fire no events for axes and buttons. */
  poll(): void {
    const pads: (Pad | null)[] = document.hasFocus() ? [...(navigator.getGamepads?.() ?? [])] : [];
    const pad = pads.find((each) => each?.connected && each.mapping === "standard") ?? null;
    const before = JSON.stringify(this.#held.state.gamepad);
    for (const change of this.#held.pad(pad)) this.#events.onChange(change);
    if (JSON.stringify(this.#held.state.gamepad) !== before) this.#events.onMove();
  }

  detach(): void {
    for (const end of this.#ends.splice(0)) end();
    if (document.pointerLockElement === this.#element) document.exitPointerLock();
  }

  #on(target: EventTarget, name: string, listener: (event: never) => void, passive = true): void {
    target.addEventListener(name, listener as EventListener, { passive });
    this.#ends.push(() => target.removeEventListener(name, listener as EventListener));
  }

  #report(change: Change | null): void {
    if (change) this.#events.onChange(change);
    else this.#events.onMove();
  }

  #listenToKeys(): void {
    const key = (event: KeyboardEvent, down: boolean): void => {
      if (this.#options.pageKeys?.(event.code)) return;
      if (NOT_OURS.has(event.code) || (down && (event.ctrlKey || event.metaKey || event.altKey))) return;
      if (event.target === this.#element) {
        // The page's own keys are not meant.
        event.preventDefault();
        event.stopPropagation();
      }
      // A key that is held on is not pressed again: everything may have been released meanwhile.
      if (event.repeat) return;
      const change = this.#held.key(event.code, down);
      if (change) this.#events.onChange(change);
    };
    this.#on(this.#element, "keydown", (event: KeyboardEvent) => key(event, true), false);
    // A key that went down here may go up anywhere.
    this.#on(window, "keyup", (event: KeyboardEvent) => key(event, false), false);
  }

  #listenToPointer(): void {
    const element = this.#element;
    this.#on(element, "pointerdown", (event: PointerEvent) => {
      element.focus({ preventScroll: true });
      if (event.pointerType !== "touch" && this.#options.pointerLock) void element.requestPointerLock();
      else element.setPointerCapture?.(event.pointerId);
      this.#pressed(event, true);
    });
    this.#on(element, "pointermove", (event: PointerEvent) => {
      const [x, y] = this.#place(event);
      if (event.pointerType === "touch") {
        if (this.#held.state.touches?.some(([id]) => id === event.pointerId))
          this.#report(this.#held.touch(event.pointerId, true, x, y));
      } else {
        this.#held.move(x, y, event.buttons);
        this.#events.onMove();
      }
    });
    for (const name of ["pointerup", "pointercancel"])
      this.#on(window, name, (event: PointerEvent) => this.#lifted(event));
    this.#on(
      element,
      "wheel",
      (event: WheelEvent) => {
        event.preventDefault();
        const [x, y] = this.#place(event);
        this.#report(this.#held.wheel(event.deltaX, event.deltaY, x, y));
      },
      false,
    );
    this.#on(element, "contextmenu", (event: Event) => event.preventDefault(), false);
  }

  #pressed(event: PointerEvent, down: boolean): void {
    const [x, y] = this.#place(event);
    if (event.pointerType === "touch") this.#report(this.#held.touch(event.pointerId, down, x, y));
    else this.#report(this.#held.button(event.button, down, x, y, event.buttons));
  }

  /** Ignores what was pressed outside of the element. */
  #lifted(event: PointerEvent): void {
    const { pointer, touches } = this.#held.state;
    const ours =
      event.pointerType === "touch"
        ? touches?.some(([id]) => id === event.pointerId)
        : (pointer?.[2] ?? 0) !== 0;
    if (ours) this.#pressed(event, false);
  }

  /** Where an event happened, from 0, 0 at the top left of the element to 1, 1. */
  #place(event: MouseEvent): readonly [number, number] {
    const { left, top, width, height } = this.#element.getBoundingClientRect();
    if (document.pointerLockElement !== this.#element) {
      this.#at = [(event.clientX - left) / (width || 1), (event.clientY - top) / (height || 1)];
    } else {
      this.#at = [
        this.#at[0] + event.movementX / (width || 1),
        this.#at[1] + event.movementY / (height || 1),
      ];
    }
    this.#at = [Math.min(1, Math.max(0, this.#at[0])), Math.min(1, Math.max(0, this.#at[1]))];
    return this.#at;
  }
}
