/** Clock of the engine: its offset to this machine's, estimated as in NTP, and capture times on it. */

import { onlyComponent } from "../rois/conditions.ts";
import type { Result, SenderClock } from "../rois/generated/types.ts";
import { resultValue } from "../rois/payload.ts";

/** One query and its response. All times are milliseconds since the epoch. */
export interface ClockProbe {
  readonly sent: number;
  /** The remote clock when it answered. */
  readonly remote: number;
  readonly received: number;
}

export interface ClockOffset {
  /** Remote time minus local time, in milliseconds. */
  readonly offset: number;
  /** The offset is off by no more than this, in milliseconds. */
  readonly uncertainty: number;
}

export const SAME_CLOCK: ClockOffset = { offset: 0, uncertainty: 0 };

/** Estimates the offset from the quickest round trip, whose uncertainty is the least. Null without probes. */
export function estimateOffset(probes: readonly ClockProbe[]): ClockOffset | null {
  let best: ClockOffset | null = null;
  for (const { sent, remote, received } of probes) {
    const uncertainty = (received - sent) / 2;
    if (uncertainty < 0 || (best && best.uncertainty <= uncertainty)) continue;
    best = { offset: remote - (sent + received) / 2, uncertainty };
  }
  return best;
}

/** Reads an ISO 8601 date and time with all the digits of its second; NaN when it is none. */
export function parseDateTime(text: string): number {
  const fraction = /[.,](\d+)/.exec(text);
  const whole = Date.parse(text.replace(/[.,]\d+/, ""));
  return fraction ? whole + Number(`0.${fraction[1]}`) * 1000 : whole;
}

/** Whether a host name is this machine's own. */
export function isLoopback(hostname: string): boolean {
  return /^(localhost|.+\.localhost|127(\.\d{1,3}){3}|\[::1\]|::1)$/i.test(hostname);
}

/** The wall clock in milliseconds with the resolution of `performance.now`, which `Date.now` has not. */
export function wallNow(): number {
  const precise = performance.timeOrigin + performance.now();
  const coarse = Date.now();
  // The two drift apart when the system's clock is set; then the coarse one is right.
  return Math.abs(precise - coarse) < 2 ? precise : coarse + 0.5;
}

interface QueryOperations {
  query(queryType: string, condition: string): Promise<readonly Result[]>;
}

/** Measures the offset with five queries to a SystemInformation component. Null when it gives no time. */
export async function measureOffset(
  client: QueryOperations,
  systemInformation: string,
  now: () => number = wallNow,
): Promise<ClockOffset | null> {
  const probes: ClockProbe[] = [];
  for (let round = 0; round < 5; round++) {
    const sent = now();
    const results = await client.query("robot_position", onlyComponent(systemInformation));
    const remote = parseDateTime(resultValue(results, "timestamp") ?? "");
    if (Number.isFinite(remote)) probes.push({ sent, remote, received: now() });
  }
  return estimateOffset(probes);
}

/** Returns milliseconds since the epoch, on the engine's clock. Timestamps wrap around at 2^32. */
export function captureTime({ rtp_origin, clock_rate, wall }: SenderClock, rtpTimestamp: number): number {
  const since = (rtpTimestamp - rtp_origin) | 0;
  return wall + (1000 * since) / clock_rate;
}
