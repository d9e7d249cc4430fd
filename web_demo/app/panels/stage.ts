/** The picture, live, frozen or awaited, and the badges on it. */

import { FrameWatch, LastingPicture } from "../../sdk/media/index.ts";
import type { RemoteStream } from "../../sdk/media/index.ts";
import { byRole, byTestId, setText } from "../dom/elements.ts";

export type Look = "blind" | "waiting" | "connecting" | "live" | "suspended" | "off" | "still" | "stalled";

const WORDS: Readonly<Record<Look, string>> = {
  blind: "This body sends no picture",
  waiting: "Waiting for the body",
  connecting: "Connecting",
  live: "Live",
  suspended: "Suspended",
  off: "Disconnected",
  still: "No new picture",
  stalled: "Frozen",
};

const AWAITED = { waiting: "waiting for the body", connecting: "connecting" } as const;

/** The page shows a picture as frozen when it is this old, in milliseconds, although the stream should run. */
const FROZEN_AFTER = 1000;

export class Stage {
  readonly frames: FrameWatch;
  readonly video: HTMLVideoElement;
  readonly picture: LastingPicture;
  readonly #element: HTMLElement;
  readonly #text: HTMLElement;
  readonly #latency: HTMLElement;
  #stopListening: (() => void)[] = [];
  #stream: RemoteStream | null = null;

  /** @param root what the picture and its badges are part of */
  constructor(root: ParentNode) {
    this.video = byTestId("avatar-video", HTMLVideoElement, root);
    this.#element = byTestId("stage", HTMLElement, root);
    this.#text = byRole("stage-text", HTMLElement, root);
    this.#latency = byRole("stage-latency", HTMLElement, root);
    this.frames = new FrameWatch(this.video);
    this.picture = new LastingPicture(
      this.video,
      byRole("last-picture", HTMLCanvasElement, root),
      this.frames,
    );
    // An attribute alone does not mute in every browser, and only a muted video may start by itself.
    this.video.muted = true;
    // The first picture takes the placeholder's place at once; the next rendering may be half a second away.
    this.frames.onFrame(() => this.#element.classList.remove("empty"));
  }

  get element(): HTMLElement {
    return this.#element;
  }

  /** Milliseconds since the last frame was shown; null before the first of this stream. */
  get frameAge(): number | null {
    return this.frames.lastAt === null ? null : performance.now() - this.frames.lastAt;
  }

  /** Shows another stream; null when the body has none. */
  watch(stream: RemoteStream | null): void {
    for (const stop of this.#stopListening) stop();
    this.#stream = stream;
    this.#stopListening = [];
    if (!stream) return this.picture.freeze();
    this.#stopListening = [
      stream.on("track", (track) => this.picture.show(track)),
      stream.on("interrupted", () => this.picture.freeze()),
    ];
    if (stream.track) this.picture.show(stream.track);
  }

  /** @param latency milliseconds, or null when unknown */
  render(present: boolean, latency: number | null): void {
    const look = this.#currentLook(present);
    this.#element.dataset["look"] = look;
    this.#element.classList.toggle("empty", !this.picture.shown);
    const awaited = look === "waiting" || look === "connecting";
    // A picture from before is to be looked at meanwhile, but it says nothing about now.
    setText(this.#text, awaited && this.picture.shown ? `Frozen: ${AWAITED[look]}` : WORDS[look]);
    this.#latency.hidden = look !== "live" || latency === null;
    if (latency !== null) setText(this.#latency, `${Math.max(0, Math.round(latency))} ms`);
  }

  #currentLook(present: boolean): Look {
    const stream = this.#stream;
    const age = this.frameAge;
    if (!stream && present) return "blind";
    if (!stream || (!present && (age === null || age > FROZEN_AFTER))) return "waiting";
    if (stream.desire === "disconnected") return "off";
    if (stream.status === "STREAMING_SUSPENDED") return "suspended";
    if (stream.track === null || age === null) return "connecting";
    if (age <= FROZEN_AFTER || document.visibilityState === "hidden") return "live";
    return stream.status === "STREAMING_RUNNING" ? "stalled" : "still";
  }
}
