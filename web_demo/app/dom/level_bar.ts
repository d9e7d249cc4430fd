/** A level as a bar, and the level of a track of this machine. */

import { SILENCE, filled, levelOf, spoken } from "../model/decibels.ts";
import type { Level } from "../model/decibels.ts";
import { make } from "./elements.ts";

export class LevelBar {
  readonly element: HTMLElement;
  readonly #bar: HTMLElement;

  constructor(name: string, label: string) {
    const id = `level-${name}`;
    this.#bar = make(
      "span",
      { class: "level", role: "meter", "aria-labelledby": id, "aria-valuemin": "0", "aria-valuemax": "100" },
      make("i"),
    );
    this.#bar.dataset["testid"] = id;
    this.element = make("div", { class: "level-row" }, make("span", { id }, label), this.#bar);
    this.show(SILENCE);
  }

  show(level: Level): void {
    const { style, dataset } = this.#bar;
    style.setProperty("--level", filled(level.rms).toFixed(3));
    style.setProperty("--peak", filled(level.peak).toFixed(3));
    dataset["value"] = level.rms.toFixed(1);
    this.#bar.setAttribute("aria-valuenow", (100 * filled(level.rms)).toFixed(0));
    this.#bar.setAttribute("aria-valuetext", spoken(level));
  }
}

/** Measures the level of a track once per drawn frame; without a track nothing runs. */
export class TrackLevel {
  readonly #onLevel: (level: Level) => void;
  #track: MediaStreamTrack | null = null;
  #context: AudioContext | null = null;

  constructor(onLevel: (level: Level) => void) {
    this.#onLevel = onLevel;
  }

  follow(track: MediaStreamTrack | null): void {
    if (track === this.#track) return;
    this.#track = track;
    void this.#context?.close();
    this.#context = null;
    this.#onLevel(SILENCE);
    if (track) this.#measure(track);
  }

  #measure(track: MediaStreamTrack): void {
    const context = new AudioContext();
    this.#context = context;
    const analyser = new AnalyserNode(context, { fftSize: 2048 });
    new MediaStreamAudioSourceNode(context, { mediaStream: new MediaStream([track]) }).connect(analyser);
    const samples = new Float32Array(analyser.fftSize);
    const look = (): void => {
      if (this.#context !== context) return;
      requestAnimationFrame(look);
      analyser.getFloatTimeDomainData(samples);
      this.#onLevel(levelOf(samples));
    };
    look();
  }
}
