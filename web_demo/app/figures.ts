/** The live figures beside the picture. */

import { RecentMedian } from "../sdk/media/index.ts";
import type { ClockOffset, Figures, RemoteStream, StampReading } from "../sdk/media/index.ts";
import { byRole, icon, make, setText } from "./dom.ts";
import { formatBitrate, formatLatency, formatNumber } from "./format.ts";
import { History } from "./sparkline.ts";

/** Figures that are older than this, in milliseconds, are not shown: they come once a second. */
const FRESH = 2500;
const SPARK_WIDTH = 96;
const SPARK_HEIGHT = 32;

class Figure {
  readonly #value: HTMLElement;
  readonly #unit = make("span", { class: "unit" });
  readonly #item: HTMLElement;
  readonly #paths: SVGPathElement[] = [];
  readonly #history = new History();

  constructor(list: HTMLElement, name: string, label: string, title: string, spark: boolean) {
    this.#value = make("span", { "data-testid": `figure-${name}` }, "–");
    this.#item = make("dd", {}, this.#value, this.#unit);
    const cell = make("div", { class: "figure", title }, make("dt", {}, label), this.#item);
    if (spark) {
      const svg = icon("", "");
      svg.setAttribute("viewBox", `0 0 ${SPARK_WIDTH} ${SPARK_HEIGHT}`);
      svg.setAttribute("preserveAspectRatio", "none");
      svg.classList.add("spark");
      this.#paths.push(...svg.querySelectorAll("path"));
      cell.append(svg);
    }
    list.append(cell);
  }

  /** @param value null shows a dash */
  set(value: number | null, text: string, unit = ""): void {
    setText(this.#value, value === null ? "–" : text);
    setText(this.#unit, value === null ? "" : unit);
    this.#value.dataset["value"] = value === null ? "" : String(value);
    this.#history.push(value);
    const [areaPath, linePath] = this.#paths;
    if (!areaPath || !linePath) return;
    const { line, area } = this.#history.paths(SPARK_WIDTH, SPARK_HEIGHT);
    areaPath.setAttribute("d", area);
    linePath.setAttribute("d", line);
  }

  set title(text: string) {
    this.#item.parentElement?.setAttribute("title", text);
  }
}

export class FiguresPanel {
  readonly #figures;
  readonly #latencies = new RecentMedian(2000);
  #clock: ClockOffset | null = null;
  #presented = 0;
  #presentedAt = performance.now();
  #newest: Figures | null = null;
  #newestAt = 0;
  #stopListening: (() => void) | null = null;

  constructor() {
    const list = byRole("figure-list", HTMLElement);
    this.#figures = {
      fps: new Figure(list, "fps", "Frame rate", "Frames shown per second", true),
      latency: new Figure(list, "latency", "Latency", "", true),
      bitrate: new Figure(list, "bitrate", "Bitrate", "Video received, without headers", true),
      rtt: new Figure(list, "rtt", "Round trip", "Of the media's network path", true),
      resolution: new Figure(list, "resolution", "Resolution", "Of the video as received", false),
      dropped: new Figure(list, "dropped", "Dropped", "Frames received and never shown", false),
      buffer: new Figure(list, "buffer", "Jitter buffer", "How long frames wait for late packets", false),
      lost: new Figure(list, "lost", "Packets lost", "Since the stream began", false),
    };
    setInterval(() => this.#render(), 1000);
  }

  /** Milliseconds from the camera to this screen, median of the last two seconds; null when it cannot be told. */
  get latency(): number | null {
    return this.#clock === null ? null : this.#latencies.value(performance.now());
  }

  watch(stream: RemoteStream): void {
    this.#stopListening?.();
    this.#stopListening = stream.on("figures", (figures) => {
      this.#newest = figures;
      this.#newestAt = performance.now();
    });
  }

  /** Null when the engine's clock is not known, and with it the latency. */
  setClock(clock: ClockOffset | null): void {
    this.#clock = clock;
    const trust =
      clock === null
        ? "Unknown: the avatar's clock has not been read"
        : `From the camera to this screen, read from the stamp in the picture; exact to ${formatNumber(clock.uncertainty + 1, 0)} ms`;
    this.#figures.latency.title = trust;
  }

  frameShown(): void {
    this.#presented += 1;
  }

  stampRead({ takenAt, visibleAt }: StampReading): void {
    if (this.#clock) this.#latencies.push(performance.now(), visibleAt - (takenAt - this.#clock.offset));
  }

  #render(): void {
    const now = performance.now();
    const fps = (1000 * this.#presented) / (now - this.#presentedAt);
    this.#presented = 0;
    this.#presentedAt = now;
    const received = now - this.#newestAt < FRESH ? this.#newest : null;
    const { latency } = this;
    const { fps: rate, latency: delay, bitrate, rtt, resolution, dropped, buffer, lost } = this.#figures;
    const shown = received && received.width > 0 ? received : null;
    rate.set(shown && fps, formatNumber(fps, 1), "fps");
    delay.set(latency, formatLatency(latency), "ms");
    bitrate.set(shown && shown.bitrate, ...formatBitrate(shown?.bitrate ?? 0));
    rtt.set(shown && shown.roundTrip, formatLatency(shown?.roundTrip ?? null), "ms");
    resolution.set(shown && shown.height, `${shown?.width ?? 0} × ${shown?.height ?? 0}`);
    dropped.set(shown && shown.dropped, formatNumber(shown?.dropped ?? 0, 0));
    buffer.set(shown && shown.bufferDelay, formatLatency(shown?.bufferDelay ?? null), "ms");
    lost.set(shown && shown.packetsLost, formatNumber(shown?.packetsLost ?? 0, 0));
  }
}
