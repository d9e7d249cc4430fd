/** The messages of the data channels, as `docs/reference/wire.md` has them. Pure. */

/** Reason for releasing everything. */
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

/** Input refused, figure stopped, or its speed changed. */
const ENGINE_EVENTS = ["refused", "stopped", "paced"] as const;

/** Message of the engine on the control channel. */
export interface EngineMessage {
  readonly event: (typeof ENGINE_EVENTS)[number];
  readonly reason: string;
}

/** Counter of all input messages of the page: of two, the engine uses the later one. */
let last = 0;

/** Returns a message with the next number and the time of now. */
export function message(body: HeldState | Change): string {
  last += 1;
  return JSON.stringify({ seq: last, t: Math.round(performance.now() * 10) / 10, ...body });
}

/** Reads a message of the engine; null for an unknown one. */
export function readEngineMessage(text: unknown): EngineMessage | null {
  try {
    const { event, reason } = JSON.parse(String(text)) as Partial<EngineMessage>;
    return event && ENGINE_EVENTS.includes(event) && typeof reason === "string" ? { event, reason } : null;
  } catch {
    return null;
  }
}
