import { afterEach, beforeEach, expect, it, vi } from "vitest";
import { FrameWatch, LastingPicture } from "../../sdk/media/frames.ts";

type FrameMetadata = Partial<VideoFrameCallbackMetadata>;

/** A video element whose frames the test presents. */
class FakeVideo {
  videoWidth = 640;
  videoHeight = 360;
  readyState = 2;
  srcObject: object | null = null;
  #callback: ((now: number, metadata: FrameMetadata) => void) | null = null;
  readonly #listeners: (() => void)[] = [];

  requestVideoFrameCallback(callback: (now: number, metadata: FrameMetadata) => void): void {
    this.#callback = callback;
  }

  addEventListener(_: string, listener: () => void): void {
    this.#listeners.push(listener);
  }

  play(): Promise<void> {
    return Promise.resolve();
  }

  load(): void {
    for (const listener of this.#listeners) listener();
  }

  present(metadata: FrameMetadata): void {
    this.#callback?.(0, { expectedDisplayTime: 0, presentedFrames: 1, ...metadata });
  }
}

const REAL = { rtpTimestamp: 1 };
const MADE_HERE = {};

let video: FakeVideo;
let canvas: { hidden: boolean; getContext(): null };
let frames: FrameWatch;
let picture: LastingPicture;
let turns: (() => void)[];

/** The browser draws the page so many times. */
function draw(times: number): void {
  for (let time = 0; time < times; time++) for (const turn of turns.splice(0)) turn();
}

beforeEach(() => {
  turns = [];
  vi.stubGlobal("requestAnimationFrame", (turn: () => void) => turns.push(turn));
  vi.stubGlobal("HTMLMediaElement", { HAVE_CURRENT_DATA: 2 });
  vi.stubGlobal("MediaStream", class {});
  video = new FakeVideo();
  canvas = { hidden: false, getContext: () => null };
  frames = new FrameWatch(video as unknown as HTMLVideoElement);
  const element = video as unknown as HTMLVideoElement;
  picture = new LastingPicture(element, canvas as unknown as HTMLCanvasElement, frames);
  picture.show({} as MediaStreamTrack);
  video.load();
  video.present(REAL);
  draw(2);
});

afterEach(() => {
  vi.unstubAllGlobals();
});

it("keeps the last picture until a frame of the next track is on the screen", () => {
  expect(canvas.hidden).toBe(true);
  picture.freeze();
  expect(canvas.hidden).toBe(false);
  picture.show({} as MediaStreamTrack);
  video.present(REAL);
  draw(2);
  expect(canvas.hidden).toBe(false);
  video.load();
  video.present(REAL);
  draw(1);
  expect(canvas.hidden).toBe(false);
  draw(1);
  expect(canvas.hidden).toBe(true);
});

it("ignores frames that the browser made itself", () => {
  const counted = vi.fn();
  frames.onFrame(counted);
  picture.freeze();
  picture.show({} as MediaStreamTrack);
  video.load();
  video.present(MADE_HERE);
  draw(2);
  expect(canvas.hidden).toBe(false);
  expect(counted).not.toHaveBeenCalled();
});

it("does not take away a picture that is kept anew meanwhile", () => {
  picture.freeze();
  picture.show({} as MediaStreamTrack);
  video.load();
  video.present(REAL);
  picture.freeze();
  draw(2);
  expect(canvas.hidden).toBe(false);
});

it("counts all frames of a browser without RTP timestamps", () => {
  const other = new FakeVideo();
  const counted = vi.fn();
  new FrameWatch(other as unknown as HTMLVideoElement).onFrame(counted);
  other.present(MADE_HERE);
  expect(counted).toHaveBeenCalledOnce();
});

it("gives the RTP timestamp of each frame, where the browser does", () => {
  const seen: (number | null)[] = [];
  frames.onFrame(({ rtpTimestamp }) => seen.push(rtpTimestamp));
  video.present({ rtpTimestamp: 0 });
  video.present({ rtpTimestamp: 4_000_000_000 });
  expect(seen).toEqual([0, 4_000_000_000]);
});

it("believes no time of display that is far behind the frame", () => {
  const seen: number[] = [];
  frames.onFrame(({ visibleAt }) => seen.push(visibleAt));
  video.present({ ...REAL, expectedDisplayTime: 16 });
  video.present({ ...REAL, expectedDisplayTime: 280 });
  expect(seen).toEqual([16, 50]);
});
