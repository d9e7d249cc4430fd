/** Reports of the playout delay to the engine, which needs it to know when a word is audible. */

import { RpcError } from "../jsonrpc/session.ts";
import { RoISError } from "../rois/errors.ts";
import type { Call } from "../rois/link.ts";

/** Least milliseconds between two reports of one stream; a greater delay is reported at once. */
const EVERY = 2000;
/** Least change in milliseconds to report. */
const CHANGE = 10;
/** Milliseconds for which a measured delay counts: the engine must not wait too short. */
const LATELY = 3000;
/** Most milliseconds that the engine accepts. */
const MOST = 60_000;

/** The part of a stream that reports need. */
export interface Played {
  readonly streamId: string | null;
  /** Newest milliseconds from arrival to playing; null while nothing plays. */
  readonly delay: number | null;
}

/** Reporter of one stream: sends the largest delay of the last seconds when it has changed. */
export class PlayoutReports {
  readonly #call: Call;
  #streamId: string | null = null;
  #measured: { readonly at: number; readonly delay: number }[] = [];
  #reported: number | null = null;
  #reportedAt = -Infinity;
  #unwanted = false;

  constructor(call: Call) {
    this.#call = call;
  }

  /** Takes a measured delay, about once a second; `now`: milliseconds, monotonic. */
  observeDelay({ streamId, delay }: Played, now: number): void {
    if (streamId !== this.#streamId) this.#begin(streamId);
    if (streamId === null || delay === null || this.#unwanted) return;
    this.#measured = [...this.#measured.filter(({ at }) => at > now - LATELY), { at: now, delay }];
    const milliseconds = Math.min(Math.round(Math.max(...this.#measured.map((each) => each.delay))), MOST);
    const later = milliseconds - (this.#reported ?? -Infinity);
    if (Math.abs(later) < CHANGE || (later < 0 && now - this.#reportedAt < EVERY)) return;
    [this.#reported, this.#reportedAt] = [milliseconds, now];
    void this.#sendReport(streamId, milliseconds);
  }

  #begin(streamId: string | null): void {
    [this.#streamId, this.#measured, this.#reported] = [streamId, [], null];
    [this.#reportedAt, this.#unwanted] = [-Infinity, false];
  }

  async #sendReport(streamId: string, milliseconds: number): Promise<void> {
    try {
      await this.#call("rois.stream.report_playout", { stream_id: streamId, milliseconds });
    } catch (error) {
      if (streamId !== this.#streamId) return;
      const refused = error instanceof RoISError && error.returnCode !== "OUT_OF_RESOURCES";
      // An engine that does not know the method gets no further reports of this stream; a lost report is sent again.
      if (refused || error instanceof RpcError) this.#unwanted = true;
      else this.#reported = null;
    }
  }
}
