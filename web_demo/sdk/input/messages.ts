/** The messages of the data channels, as `docs/wire.md` has them. Pure. */

/** Why all is let go. */
export type Why = "blur" | "hidden" | "bye" | "lost";

export interface Gamepad4 {
  readonly axes: readonly number[];
  readonly buttons: readonly number[];
}

/** All that is held at one moment; what is not there is left out. */
export interface HeldState {
  readonly keys?: readonly string[];
  /** x and y from 0 to 1, and `MouseEvent.buttons`. */
  readonly pointer?: readonly [number, number, number];
  /** Identifier, x and y of each finger. */
  readonly touches?: readonly (readonly [number, number, number])[];
  readonly gamepad?: Gamepad4;
}

export type Change =
  | { readonly event: "key"; readonly code: string; readonly down: boolean }
  | {
      readonly event: "button";
      readonly button: number;
      readonly down: boolean;
      readonly x: number;
      readonly y: number;
    }
  | {
      readonly event: "wheel";
      readonly dx: number;
      readonly dy: number;
      readonly x: number;
      readonly y: number;
    }
  | {
      readonly event: "touch";
      readonly id: number;
      readonly down: boolean;
      readonly x: number;
      readonly y: number;
    }
  | { readonly event: "pad"; readonly button: number; readonly down: boolean }
  | { readonly event: "release"; readonly why: Why };

/** It takes no input, has stopped the figure, or has it go slower or at full speed again. */
const TOLD = ["refused", "stopped", "paced"] as const;

/** What the engine says back. */
export interface Told {
  readonly event: (typeof TOLD)[number];
  readonly reason: string;
}

/** One counter for all messages of the page: what is sent later counts more, whoever sends it. */
let last = 0;

/** Returns a message with the next number and the time of now. */
export function message(body: HeldState | Change): string {
  last += 1;
  return JSON.stringify({ seq: last, t: Math.round(performance.now() * 10) / 10, ...body });
}

/** Reads what the engine says; null for what is not known. */
export function readTold(text: unknown): Told | null {
  try {
    const { event, reason } = JSON.parse(String(text)) as Partial<Told>;
    return event && TOLD.includes(event) && typeof reason === "string" ? { event, reason } : null;
  } catch {
    return null;
  }
}
