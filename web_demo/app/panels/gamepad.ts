/** The connected gamepad: its name, and whether it can drive. */

const LONGEST = 32;

export interface Pad {
  readonly name: string;
  /** Its buttons stand where the standard mapping has them; another one cannot drive. */
  readonly standard: boolean;
}

/** Watches gamepads come and go. Browsers show one to a page only after a press of a button. */
export class GamepadWatch {
  #pad: Pad | null = null;

  /** @param onChange is called with another gamepad, or null for none */
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

/** Leaves out vendor and product numbers, and what is said of the mapping. */
export function padName(id: string): string {
  const plain = id
    .replace(/\([^()]*\b(vendor|product|standard gamepad)\b[^()]*\)?/gi, "")
    .replace(/^[0-9a-f]{4}-[0-9a-f]{4}-/i, "")
    .replace(/\s+/g, " ")
    .trim();
  return plain === "" ? "Gamepad" : plain.length > LONGEST ? `${plain.slice(0, LONGEST - 1)}…` : plain;
}
