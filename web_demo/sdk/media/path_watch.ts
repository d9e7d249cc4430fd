/** Detects a broken media path of a peer connection by what arrives. Pure: the time is an argument. */

/** A stream that the peer carries. */
export interface Flow {
  readonly streamId: string;
  /** Media should be arriving now: wanted, not suspended, and the engine says that it sends or is about to. */
  readonly expected: boolean;
  /** Any counter that changes while media arrives; 0 before the first. */
  readonly count: number;
}

export type Verdict =
  /** All that is expected arrives. */
  | "fine"
  /** Something is late, or a restart was asked for and has not come. */
  | "waiting"
  /** Ask the engine for a new peer connection. */
  | "restart";

/**
 * Milliseconds until the first frame, of silence between frames, and of ICE without a working pair. A browser calls a
 * pair disconnected after seconds of silence, and an engine gives up a receiver that is silent for four.
 */
export const FIRST_FRAME_WITHIN = 10_000;
const SILENCE_LIMIT = 2_000;
const DISCONNECTED_LIMIT = 1_000;
const LATE_AFTER = 1_000;
const FIRST_PATIENCE = 5_000;
const MAX_PATIENCE = 30_000;

interface Progress {
  count: number;
  at: number;
}

export class PathWatch {
  readonly #progress = new Map<string, Progress>();
  #disconnectedSince: number | null = null;
  #quietUntil = 0;
  #patience = FIRST_PATIENCE;

  /** Returns the verdict; to be called about once a second with all flows. `now`: milliseconds, monotonic. */
  observe(now: number, connection: RTCPeerConnectionState, flows: readonly Flow[]): Verdict {
    const broken = this.#judgeConnection(now, connection);
    for (const streamId of this.#progress.keys()) {
      if (!flows.some((flow) => flow.streamId === streamId)) this.#progress.delete(streamId);
    }
    const late = flows.map((flow) => this.#judgeFlow(now, flow));
    const verdict: Verdict =
      broken === "restart" || late.includes("restart")
        ? "restart"
        : broken === "waiting" || late.includes("waiting")
          ? "waiting"
          : "fine";
    if (verdict === "fine") this.#patience = FIRST_PATIENCE;
    if (verdict !== "restart") return verdict;
    if (now < this.#quietUntil) return "waiting";
    this.#quietUntil = now + this.#patience;
    this.#patience = Math.min(MAX_PATIENCE, this.#patience * 1.5);
    return "restart";
  }

  #judgeConnection(now: number, connection: RTCPeerConnectionState): Verdict {
    if (connection === "failed" || connection === "closed") return "restart";
    if (connection !== "disconnected") {
      this.#disconnectedSince = null;
      return "fine";
    }
    this.#disconnectedSince ??= now;
    return now - this.#disconnectedSince >= DISCONNECTED_LIMIT ? "restart" : "waiting";
  }

  #judgeFlow(now: number, { streamId, expected, count }: Flow): Verdict {
    const progress = this.#progress.get(streamId);
    if (!progress || !expected || progress.count !== count) {
      this.#progress.set(streamId, { count, at: now });
      return "fine";
    }
    const silence = now - progress.at;
    if (silence >= (count === 0 ? FIRST_FRAME_WITHIN : SILENCE_LIMIT)) return "restart";
    return silence >= LATE_AFTER ? "waiting" : "fine";
  }
}
