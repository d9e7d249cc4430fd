/** The statistics of the last minute, drawn over the picture. While it is hidden nothing is drawn. */

import { byRole, byTestId, icon, make, setText } from "../dom/elements.ts";
import { formatBitrate, formatLatency, formatNumber } from "../model/format.ts";
import type { Reading, Readings } from "../model/readings.ts";
import { History, roundTop } from "../dom/sparkline.ts";

const WIDTH = 120;
const HEIGHT = 40;

/** Returns a number and its unit. */
type Format = (value: number) => readonly [string, string];

interface Chart {
  readonly name: string;
  readonly label: string;
  readonly title: string;
  /** The upper edge is a round number, and never less than this. */
  readonly least: number;
  readonly format: Format;
  /** One line, or two: the picture's and the sound's. */
  readonly lines: readonly ((reading: Reading) => number | null)[];
  /** What is written instead of the number. */
  readonly words?: (reading: Reading) => readonly [string, string];
}

const milliseconds: Format = (value) => [formatLatency(value), "ms"];

const CHARTS: readonly Chart[] = [
  {
    name: "rate",
    label: "Frame rate",
    title: "Frames shown per second",
    least: 30,
    format: (value) => [formatNumber(value, value < 10 ? 1 : 0), "fps"],
    lines: [({ rate }) => rate],
  },
  {
    name: "latency",
    label: "To the screen",
    title: "From the body's camera to this screen",
    least: 50,
    format: milliseconds,
    lines: [({ latency }) => latency],
  },
  {
    name: "bitrate",
    label: "Bit rate",
    title: "Video received, without headers",
    least: 100e3,
    format: formatBitrate,
    lines: [({ video }) => video && video.bitrate],
  },
  {
    name: "loss",
    label: "Packet loss",
    title: "Video packets that did not arrive, repaired ones not counted",
    least: 1,
    format: (value) => [formatNumber(value, value > 0 && value < 10 ? 1 : 0), "%"],
    lines: [({ video }) => video && 100 * video.loss],
  },
  {
    name: "buffer",
    label: "Jitter buffer",
    title: "How long picture and sound wait for late packets, and for each other",
    least: 50,
    format: milliseconds,
    lines: [({ video }) => video && video.bufferDelay, ({ audio }) => audio && audio.bufferDelay],
  },
  {
    name: "frozen",
    label: "Frozen",
    title: "For how much of each second the picture stood still",
    least: 100,
    format: (value) => [formatNumber(value, 0), "ms/s"],
    lines: [({ frozen }) => frozen],
  },
  {
    name: "rtt",
    label: "Round trip",
    title: "Of the media's network path",
    least: 10,
    format: milliseconds,
    lines: [({ video }) => video && video.roundTrip],
  },
  {
    name: "resolution",
    label: "Resolution",
    title: "Lines of the video as received, and its codec",
    least: 200,
    format: (value) => [formatNumber(value, 0), "lines"],
    lines: [({ video }) => video && video.height],
    words: ({ video }) => [
      `${video?.width ?? 0}\u2009×\u2009${video?.height ?? 0}`,
      video?.codec.replace(/^video\//, "") ?? "",
    ],
  },
];

class Tile {
  readonly element: HTMLElement;
  readonly #chart: Chart;
  readonly #value = make("span");
  readonly #unit = make("span", { class: "unit" });
  readonly #top = make("span", { class: "top", "aria-hidden": "true" });
  readonly #histories: readonly History[];
  readonly #paths: readonly SVGPathElement[];
  #newest: Reading | null = null;

  constructor(chart: Chart) {
    this.#chart = chart;
    this.#histories = chart.lines.map(() => new History());
    this.#value.dataset["testid"] = `plot-${chart.name}`;
    const svg = icon(`M0 ${HEIGHT / 2}H${WIDTH}`, ...chart.lines.flatMap(() => ["", ""]));
    svg.setAttribute("viewBox", `0 0 ${WIDTH} ${HEIGHT}`);
    svg.setAttribute("preserveAspectRatio", "none");
    this.#paths = [...svg.querySelectorAll("path")].slice(1);
    this.element = make(
      "div",
      { title: chart.title, "data-plot": chart.name },
      make("dt", {}, chart.label),
      make("dd", {}, this.#value, this.#unit),
      make("div", { class: "plot", "aria-hidden": "true" }, svg, this.#top),
    );
  }

  /** Adds a reading, also while hidden: the last minute is shown when the overlay is opened. */
  add(reading: Reading): void {
    this.#newest = reading;
    this.#histories.forEach((history, index) => history.push(this.#chart.lines[index]?.(reading) ?? null));
  }

  draw(): void {
    if (!this.#newest) return;
    const { lines, format, words, least } = this.#chart;
    const values = lines.map((line) => this.#newest && line(this.#newest));
    const [first] = values;
    const [text, unit] = first == null ? ["–", ""] : (words?.(this.#newest) ?? format(first));
    const second = values[1] == null ? "" : ` | ${format(values[1])[0]}`;
    setText(this.#value, text + second);
    setText(this.#unit, unit);
    this.#value.dataset["value"] = first == null ? "" : String(first);
    const top = roundTop(Math.max(...this.#histories.map(({ greatest }) => greatest)), least);
    setText(this.#top, format(top).join(" "));
    this.#histories.forEach((history, index) => {
      const { line, area } = history.paths(WIDTH, HEIGHT, top);
      this.#paths[2 * index]?.setAttribute("d", area);
      this.#paths[2 * index + 1]?.setAttribute("d", line);
    });
  }
}

export class Overlay {
  readonly #element = byTestId("statistics", HTMLElement);
  readonly #button = byTestId("statistics-toggle", HTMLButtonElement);
  readonly #tiles = CHARTS.map((chart) => new Tile(chart));

  constructor(readings: Readings) {
    byRole("statistics-list", HTMLElement).append(...this.#tiles.map(({ element }) => element));
    this.#button.addEventListener("click", () => this.toggle());
    readings.onReading((reading) => {
      for (const tile of this.#tiles) tile.add(reading);
      if (this.shown) this.#draw();
    });
  }

  get shown(): boolean {
    return !this.#element.hidden;
  }

  set shown(shown: boolean) {
    this.#element.hidden = !shown;
    this.#button.setAttribute("aria-pressed", String(shown));
    if (shown) this.#draw();
  }

  toggle(): void {
    this.shown = !this.shown;
  }

  #draw(): void {
    for (const tile of this.#tiles) tile.draw();
  }
}
