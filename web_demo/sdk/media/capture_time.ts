/** When what arrives was captured, by its RTP timestamps. */

import type { SenderClock } from "../rois/generated/types.ts";

/** Returns milliseconds since the epoch, on the engine's clock. Timestamps wrap around at 2^32. */
export function captureTime({ rtp_origin, clock_rate, wall }: SenderClock, rtpTimestamp: number): number {
  const since = (rtpTimestamp - rtp_origin) | 0;
  return wall + (1000 * since) / clock_rate;
}
