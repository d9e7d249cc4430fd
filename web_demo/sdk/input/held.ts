/** What is held on keyboard, mouse, touch screen and gamepad. Pure. */

import type { Change, Gamepad4, HeldState } from "./messages.ts";

const MAX_KEYS = 16;
const MAX_TOUCHES = 10;
const MAX_BUTTONS = 17;
const MAX_AXES = 4;
/** Dead zone of axes and analogue buttons at rest. */
const AT_REST = 0.05;
const CODE = /^[A-Za-z0-9]{1,32}$/;
/** Threshold of an analogue button, as in browsers. */
const PRESSED = 0.5;

const fine = (value: number, low: number): number =>
  Math.round(Math.min(1, Math.max(low, Number.isFinite(value) ? value : 0)) * 10_000) / 10_000;

/** What is held on while everything is halted: it counts again once it has been let go. */
interface Halted {
  readonly pad: boolean;
  readonly stick: boolean;
  /** Buttons of the mouse, as `MouseEvent.buttons`. */
  readonly buttons: number;
}

const NOTHING: Halted = { pad: false, stick: false, buttons: 0 };

/** State of the input devices. Methods return the change to send at once; null where the state alone is enough. */
export class Held {
  readonly #keys = new Set<string>();
  readonly #touches = new Map<number, readonly [number, number]>();
  #pointer: readonly [number, number, number] | null = null;
  #gamepad: Gamepad4 | null = null;
  /** A stick on the screen, as the left stick of a gamepad. */
  #stick: readonly [number, number] | null = null;
  #halted = NOTHING;

  /** The state in the form of a message. */
  get state(): HeldState {
    return {
      ...(this.#keys.size > 0 && { keys: [...this.#keys] }),
      ...(this.#pointer && { pointer: this.#pointer }),
      ...(this.#touches.size > 0 && {
        touches: [...this.#touches].map(([id, [x, y]]) => [id, x, y] as const),
      }),
      ...(this.#pad && { gamepad: this.#pad }),
    };
  }

  /** Whether anything is pressed, touched or deflected: states have to be repeated meanwhile. */
  get active(): boolean {
    return (
      this.#keys.size > 0 ||
      this.#touches.size > 0 ||
      (this.#pointer?.[2] ?? 0) !== 0 ||
      isDeflected(this.#pad)
    );
  }

  key(code: string, down: boolean): Change | null {
    if (!CODE.test(code) || this.#keys.has(code) === down) return null;
    if (down && this.#keys.size >= MAX_KEYS) return null;
    if (down) this.#keys.add(code);
    else this.#keys.delete(code);
    return { event: "key", code, down };
  }

  /** Sets the pointer's place and buttons. */
  move(x: number, y: number, buttons: number): void {
    const halted = this.#halted.buttons & buttons;
    this.#halted = { ...this.#halted, buttons: halted };
    this.#pointer = [fine(x, 0), fine(y, 0), buttons & ~halted & 31];
  }

  button(button: number, down: boolean, x: number, y: number, buttons: number): Change | null {
    this.move(x, y, buttons);
    if (button < 0 || button > 4) return null;
    return { event: "button", button, down, x: fine(x, 0), y: fine(y, 0) };
  }

  wheel(dx: number, dy: number, x: number, y: number): Change {
    this.move(x, y, this.#pointer?.[2] ?? 0);
    const far = (value: number): number => Math.round(Math.min(100_000, Math.max(-100_000, value)) * 10) / 10;
    return { event: "wheel", dx: far(dx), dy: far(dy), x: fine(x, 0), y: fine(y, 0) };
  }

  touch(id: number, down: boolean, x: number, y: number): Change | null {
    const at = [fine(x, 0), fine(y, 0)] as const;
    const known = this.#touches.has(id);
    if (down && !known && this.#touches.size >= MAX_TOUCHES) return null;
    if (down) this.#touches.set(id, at);
    else this.#touches.delete(id);
    return known === down ? null : { event: "touch", id, down, x: at[0], y: at[1] };
  }

  /** Takes the gamepad as it is now, null for none; returns the buttons that went down or up. */
  pad(now: { axes: readonly number[]; buttons: readonly { value: number }[] } | null): Change[] {
    const before = this.#gamepad?.buttons ?? [];
    this.#gamepad = now && {
      axes: now.axes.slice(0, MAX_AXES).map((each) => fine(each, -1)),
      buttons: now.buttons.slice(0, MAX_BUTTONS).map(({ value }) => fine(value, 0)),
    };
    const isHalted = this.#halted.pad && (now === null || isDeflected(this.#gamepad));
    this.#halted = { ...this.#halted, pad: isHalted };
    if (isHalted) this.#gamepad = null;
    const after = this.#gamepad?.buttons ?? [];
    return Array.from({ length: MAX_BUTTONS }, (_, button) => button)
      .filter((button) => (before[button] ?? 0) >= PRESSED !== (after[button] ?? 0) >= PRESSED)
      .map((button) => ({ event: "pad", button, down: (after[button] ?? 0) >= PRESSED }));
  }

  /**
   * A stick on the screen stands here: x from -1 (left) to 1, y from -1 (up) to 1; 0, 0 is let go. It adds to the left
   * stick of the gamepad.
   */
  stick(x: number, y: number): void {
    const at = [fine(x, -1), fine(y, -1)] as const;
    const isHalted = this.#halted.stick && (at[0] !== 0 || at[1] !== 0);
    this.#halted = { ...this.#halted, stick: isHalted };
    this.#stick = isHalted || (at[0] === 0 && at[1] === 0) ? null : at;
  }

  /** The gamepad with the stick on the screen; null without either. */
  get #pad(): Gamepad4 | null {
    if (!this.#stick) return this.#gamepad;
    const { axes = [], buttons = [] } = this.#gamepad ?? {};
    const [x, y] = this.#stick;
    return { axes: [fine((axes[0] ?? 0) + x, -1), fine((axes[1] ?? 0) + y, -1), ...axes.slice(2)], buttons };
  }

  /** Releases everything. */
  clear(): void {
    this.#keys.clear();
    this.#touches.clear();
    this.#pointer = null;
    this.#gamepad = null;
    this.#stick = null;
  }

  /** Releases everything, and takes what is held on now only once it has been let go and is pressed anew. */
  halt(): void {
    this.#halted = {
      pad: this.#halted.pad || isDeflected(this.#gamepad),
      stick: this.#halted.stick || this.#stick !== null,
      buttons: this.#halted.buttons | (this.#pointer?.[2] ?? 0),
    };
    this.clear();
  }
}

function isDeflected(pad: Gamepad4 | null): boolean {
  return pad !== null && [...pad.axes, ...pad.buttons].some((each) => Math.abs(each) > AT_REST);
}
