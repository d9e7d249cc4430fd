/** What the browser counts of a stream. */

import type { Attachment } from "./place.ts";
import { readSample } from "./statistics.ts";
import type { Sample } from "./statistics.ts";
import type { ControlledStream } from "./stream.ts";

/** A hidden page may stop decoding, but the packets still come in. */
export function progress(sample: Sample | undefined): number {
  if (!sample) return 0;
  return globalThis.document?.visibilityState === "hidden" ? sample.bytes : sample.units;
}

/** Returns null where there is nothing to be counted. */
export async function readCounters(
  attachment: Attachment | null,
  { direction }: ControlledStream,
): Promise<Sample | null> {
  if (!attachment || attachment.peer.closed) return null;
  const { sender, receiver } = attachment.transceiver;
  const stats = await (direction === "sendonly" ? sender : receiver).getStats();
  return readSample((stats as unknown as Map<string, never>).values(), performance.now());
}
