/** Numbers and times as the page writes them. Pure. */

export function formatNumber(value: number, digits: number): string {
  return value.toFixed(digits);
}

/** Short times need their first decimal, long ones do not; below zero is an error of the estimated clock. */
export function formatLatency(ms: number | null): string {
  if (ms === null) return "";
  if (ms < 0) return "0.0";
  return ms < 10 ? ms.toFixed(1) : ms.toFixed(0);
}

/** Returns number and unit. */
export function formatBitrate(bitsPerSecond: number): [string, string] {
  if (bitsPerSecond >= 1e6) return [(bitsPerSecond / 1e6).toFixed(2), "Mbit/s"];
  return [(bitsPerSecond / 1e3).toFixed(0), "kbit/s"];
}

/** Returns the local time of day with milliseconds. */
export function formatTime(epochMs: number): string {
  const date = new Date(epochMs);
  const two = (value: number): string => String(value).padStart(2, "0");
  const time = [date.getHours(), date.getMinutes(), date.getSeconds()].map(two).join(":");
  return `${time}.${String(date.getMilliseconds()).padStart(3, "0")}`;
}

/** Returns the seconds until a moment, at least 1 while it is ahead. */
export function secondsUntil(epochMs: number, now: number): number {
  return Math.max(0, Math.ceil((epochMs - now) / 1000));
}
