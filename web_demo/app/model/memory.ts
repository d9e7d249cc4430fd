/** What the page remembers for when it is loaded again: what it showed, and the last picture of it. */

import type { Desire } from "../../sdk/media/index.ts";

export interface Remembered {
  readonly engineId: string;
  readonly video: Desire;
  readonly audio: Desire;
  readonly muted: boolean;
  readonly statistics: boolean;
  /** The last picture, as a `data:` URL; empty where there was none. */
  readonly picture: string;
}

/** An old picture says nothing about now: after so many milliseconds it is not shown any more. */
const PICTURE_FRESH = 30_000;
const KEY = "openrois.page";
const DESIRES: readonly unknown[] = ["running", "suspended", "disconnected"] satisfies Desire[];

/** What a browser keeps for one tab at one address: that of the gateway. */
type Store = Pick<Storage, "getItem" | "setItem">;

export function remember(store: Store, page: Remembered, now: number): void {
  try {
    store.setItem(KEY, JSON.stringify({ ...page, at: now }));
  } catch {
    // Full, or forbidden: the page begins from the beginning.
  }
}

/** Returns null where nothing, or nothing that this page understands, was remembered. */
export function recall(store: Store, now: number): Remembered | null {
  try {
    const found = JSON.parse(store.getItem(KEY) ?? "null") as Partial<Remembered & { at: number }> | null;
    if (typeof found?.engineId !== "string") return null;
    const { engineId, video = "running", audio = "running", at = 0, picture } = found;
    if (!DESIRES.includes(video) || !DESIRES.includes(audio)) return null;
    const fresh = now >= at && now - at < PICTURE_FRESH && picture?.startsWith("data:image/") === true;
    return {
      engineId,
      video,
      audio,
      muted: found.muted === true,
      statistics: found.statistics === true,
      picture: fresh ? picture : "",
    };
  } catch {
    return null;
  }
}
