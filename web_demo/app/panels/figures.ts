/** The live figures beside the picture. */

import type { ClockOffset } from "../../sdk/media/index.ts";
import { byRole, icon, make, setText } from "../dom/elements.ts";
import { formatBitrate, formatLatency, formatNumber } from "../model/format.ts";
import type { Reading, Readings } from "../model/readings.ts";
import { History } from "../dom/sparkline.ts";

const SPARK_WIDTH = 96;
const SPARK_HEIGHT = 32;

class Figure {
  readonly #value: HTMLElement;
  readonly #unit = make("span", { class: "unit" });
  readonly #cell: HTMLElement;
  readonly #paths: SVGPathElement[] = [];
  readonly #history = new History();

  constructor(list: HTMLElement, name: string, label: string, title: string, spark: boolean) {
    this.#value = make("span", { "data-testid": `figure-${name}` }, "–");
    const item = make("dd", {}, this.#value, this.#unit);
    const cell = make("div", { class: "figure", title }, make("dt", {}, label), item);
    this.#cell = cell;
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
    if (this.#cell.title !== text) this.#cell.title = text;
  }
}

export class FiguresPanel {
  readonly #figures;

  constructor(readings: Readings) {
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
    readings.onReading((reading) => this.#render(reading, readings.clock));
  }

  #render({ rate, latency, video }: Reading, clock: ClockOffset | null): void {
    const { fps, latency: delay, bitrate, rtt, resolution, dropped, buffer, lost } = this.#figures;
    fps.set(rate, formatNumber(rate ?? 0, 1), "fps");
    delay.set(latency, formatLatency(latency), "ms");
    bitrate.set(video && video.bitrate, ...formatBitrate(video?.bitrate ?? 0));
    rtt.set(video && video.roundTrip, formatLatency(video?.roundTrip ?? null), "ms");
    resolution.set(video && video.height, `${video?.width ?? 0} × ${video?.height ?? 0}`);
    dropped.set(video && video.dropped, formatNumber(video?.dropped ?? 0, 0));
    buffer.set(video && video.bufferDelay, formatLatency(video?.bufferDelay ?? null), "ms");
    lost.set(video && video.packetsLost, formatNumber(video?.packetsLost ?? 0, 0));
    delay.title = latencyTitle(clock);
  }
}

function latencyTitle(clock: ClockOffset | null): string {
  if (clock === null) return "Unknown: the body's clock has not been read";
  return `From the camera to this screen; exact to ${formatNumber(clock.uncertainty + 1, 0)} ms`;
}
