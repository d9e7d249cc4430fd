/** How late sound is played here, told to the engine: one that says when something was heard cannot know otherwise. */

import { RpcError } from "../jsonrpc/session.ts";
import { RoISError } from "../rois/errors.ts";
import type { Call } from "../rois/link.ts";

/** Milliseconds between two reports of one stream, at least; one that it is later than was told does not wait. */
const EVERY = 2000;
/** A change of so many milliseconds is worth a report. */
const CHANGE = 10;
/** Milliseconds for which a delay counts after it was measured: whoever waits for it shall not wait too short. */
const LATELY = 3000;
/** The engine takes no more, in milliseconds. */
const MOST = 60_000;

/** What of a stream is needed. */
export interface Played {
  readonly streamId: string | null;
  /** Milliseconds from arrival to playing, lately; null while nothing plays. */
  readonly delay: number | null;
}

/** The reports of one stream: the largest delay of the last seconds, when it has changed. */
export class PlayoutReports {
  readonly #call: Call;
  #streamId: string | null = null;
  #measured: { readonly at: number; readonly delay: number }[] = [];
  #told: number | null = null;
  #toldAt = -Infinity;
  #unwanted = false;

  constructor(call: Call) {
    this.#call = call;
  }

  /** To be called whenever the delay was measured, about once a second; `now` is in milliseconds of a monotonic clock. */
  look({ streamId, delay }: Played, now: number): void {
    if (streamId !== this.#streamId) this.#begin(streamId);
    if (streamId === null || delay === null || this.#unwanted) return;
    this.#measured = [...this.#measured.filter(({ at }) => at > now - LATELY), { at: now, delay }];
    const milliseconds = Math.min(Math.round(Math.max(...this.#measured.map((each) => each.delay))), MOST);
    const later = milliseconds - (this.#told ?? -Infinity);
    if (Math.abs(later) < CHANGE || (later < 0 && now - this.#toldAt < EVERY)) return;
    [this.#told, this.#toldAt] = [milliseconds, now];
    void this.#tell(streamId, milliseconds);
  }

  #begin(streamId: string | null): void {
    [this.#streamId, this.#measured, this.#told] = [streamId, [], null];
    [this.#toldAt, this.#unwanted] = [-Infinity, false];
  }

  async #tell(streamId: string, milliseconds: number): Promise<void> {
    try {
      await this.#call("rois.stream.report_playout", { stream_id: streamId, milliseconds });
    } catch (error) {
      if (streamId !== this.#streamId) return;
      const refused = error instanceof RoISError && error.returnCode !== "OUT_OF_RESOURCES";
      // Whoever does not know it is not told again of this stream; what was lost on the way is.
      if (refused || error instanceof RpcError) this.#unwanted = true;
      else this.#told = null;
    }
  }
}
