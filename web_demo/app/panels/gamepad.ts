/** Whether a gamepad is there that can drive, and what it is called. */

import { padName } from "../model/gamepad_name.ts";

export interface Pad {
  readonly name: string;
  /** Its buttons stand where the standard mapping has them; another one cannot drive. */
  readonly standard: boolean;
}

/** Tells of gamepads that come and go. Browsers show one to a page only once a button of it was pressed. */
export class GamepadWatch {
  #pad: Pad | null = null;

  /** @param onChange is called when another one is there, or none */
  constructor(onChange: (pad: Pad | null) => void) {
    const look = (): void => {
      const found = [...(navigator.getGamepads?.() ?? [])].filter((each) => each?.connected);
      const pad = found.find((each) => each?.mapping === "standard") ?? found[0] ?? null;
      const now = pad && { name: padName(pad.id), standard: pad.mapping === "standard" };
      if (now?.name === this.#pad?.name && now?.standard === this.#pad?.standard) return;
      this.#pad = now;
      onChange(now);
    };
    for (const name of ["gamepadconnected", "gamepaddisconnected"]) addEventListener(name, look);
    look();
  }

  get pad(): Pad | null {
    return this.#pad;
  }
}
