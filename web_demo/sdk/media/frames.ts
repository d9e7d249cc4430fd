/** What a video element presents, frame by frame, and the last picture for when there is none. */

import { Emitter } from "../jsonrpc/events.ts";

/** Most milliseconds from the frame callback to the screen. */
const SOON = 50;

export interface PresentedFrame {
  /** On the clock of `performance.now`, in milliseconds: when the frame is expected to be visible. */
  readonly visibleAt: number;
  /** How many frames the element has presented. */
  readonly presented: number;
  /** Of the packets that brought it; null where the browser does not say. */
  readonly rtpTimestamp: number | null;
}

/**
 * Follows the frames that a video element presents, whichever stream it shows.
 *
 * Only frames that came over the network count, where the browser marks them: a frame that the browser makes itself,
 * because a track ends or begins, is black.
 */
export class FrameWatch {
  readonly #events = new Emitter<{ frame: PresentedFrame }>();
  readonly #video: HTMLVideoElement;
  #lastAt: number | null = null;
  /** Whether this browser marks the frames that came over RTP. */
  #tells = false;

  constructor(video: HTMLVideoElement) {
    this.#video = video;
    this.#listen();
  }

  /** When the last frame was presented, on the clock of `performance.now`; null before the first. */
  get lastAt(): number | null {
    return this.#lastAt;
  }

  onFrame(listener: (frame: PresentedFrame) => void): () => void {
    return this.#events.on("frame", listener);
  }

  #listen(): void {
    this.#video.requestVideoFrameCallback((now, metadata) => {
      this.#listen();
      const received = metadata.rtpTimestamp !== undefined;
      this.#tells ||= received;
      if (this.#tells && !received) return;
      this.#lastAt = now;
      // After a pause Chromium may give a time of its smoothing, 250 ms too late: the frame is nearly on the screen.
      const visibleAt = Math.max(now, Math.min(metadata.expectedDisplayTime, now + SOON));
      this.#events.emit("frame", {
        visibleAt,
        presented: metadata.presentedFrames,
        rtpTimestamp: metadata.rtpTimestamp ?? null,
      });
    });
  }
}

/**
 * Shows a video so that it freezes and never goes black: whenever its stream is about to end or change, the last
 * picture is painted on a canvas above it, and stays until the next frame is presented.
 */
export class LastingPicture {
  readonly #video: HTMLVideoElement;
  readonly #canvas: HTMLCanvasElement;
  /** What the video presents is the track that was shown last, no longer the one before. */
  #current = false;
  /** Counts what was to be kept, so that a picture which is kept anew is not taken away for the one before. */
  #turn = 0;

  /** The canvas must cover the video; it is hidden while frames flow. */
  constructor(video: HTMLVideoElement, canvas: HTMLCanvasElement, frames: FrameWatch) {
    this.#video = video;
    this.#canvas = canvas;
    canvas.hidden = true;
    video.addEventListener("loadeddata", () => {
      this.#current = true;
    });
    frames.onFrame(() => {
      if (this.#current && !canvas.hidden) this.#reveal();
    });
  }

  /** There is a picture to look at, moving or not. */
  get shown(): boolean {
    return !this.#canvas.hidden || this.#video.readyState >= HTMLMediaElement.HAVE_CURRENT_DATA;
  }

  /** Keeps what the video shows now, until a track that is shown later brings a frame. */
  freeze(): void {
    // A track that ends presents one more frame, a black one: it must neither be shown nor be painted.
    this.#current = false;
    this.#turn += 1;
    if (!this.#canvas.hidden) return;
    const { videoWidth, videoHeight, readyState } = this.#video;
    if (videoWidth === 0 || readyState < HTMLMediaElement.HAVE_CURRENT_DATA) return;
    this.#canvas.width = videoWidth;
    this.#canvas.height = videoHeight;
    this.#canvas.getContext("2d")?.drawImage(this.#video, 0, 0);
    this.#canvas.hidden = false;
  }

  /** The frame was given to the compositor, which on a busy machine may still have nothing but black to show. */
  #reveal(): void {
    const turn = this.#turn;
    requestAnimationFrame(() =>
      requestAnimationFrame(() => {
        if (this.#turn === turn) this.#canvas.hidden = true;
      }),
    );
  }

  /** What is shown, as a `data:` URL of a JPEG that is no wider than this; empty when nothing is shown. */
  snapshot(width: number): string {
    const shown = this.#canvas.hidden ? this.#video : this.#canvas;
    const [ownWidth, ownHeight] =
      shown === this.#video
        ? [shown.videoWidth, shown.videoHeight]
        : [this.#canvas.width, this.#canvas.height];
    if (!this.shown || ownWidth === 0) return "";
    const small = document.createElement("canvas");
    small.width = Math.min(width, ownWidth);
    small.height = Math.round((small.width * ownHeight) / ownWidth);
    small.getContext("2d")?.drawImage(shown, 0, 0, small.width, small.height);
    return small.toDataURL("image/jpeg", 0.8);
  }

  /** Shows a picture of earlier until a track brings its first frame. */
  async restore(snapshot: string): Promise<void> {
    const image = new Image();
    image.src = snapshot;
    await image.decode();
    if (this.shown) return;
    this.#canvas.width = image.naturalWidth;
    this.#canvas.height = image.naturalHeight;
    this.#canvas.getContext("2d")?.drawImage(image, 0, 0);
    this.#canvas.hidden = false;
  }

  /** Shows a track from its first frame on, and what was there before until then. */
  show(track: MediaStreamTrack): void {
    this.freeze();
    this.#video.srcObject = new MediaStream([track]);
    // Autoplay refuses only sound, and a video of ours is muted; an interrupted play() is followed by another.
    void this.#video.play().catch(() => undefined);
  }
}
