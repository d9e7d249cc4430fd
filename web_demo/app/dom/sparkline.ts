/** The last minute of a figure as a line. Pure. */

/** Returns the least round number (1, 2 or 5 with zeros) that is no less than `value` and `least`. */
export function roundTop(value: number, least: number): number {
  const wanted = Math.max(value, least);
  const power = 10 ** Math.floor(Math.log10(wanted));
  return power * (NICE.find((step) => step * power >= wanted * 0.999999) ?? 10);
}

const NICE = [1, 2, 5, 10];

/** Numbers of the last `limit` steps; null where there was none. */
export class History {
  readonly #limit: number;
  readonly #values: (number | null)[] = [];

  constructor(limit = 60) {
    this.#limit = limit;
  }

  push(value: number | null): void {
    this.#values.push(value);
    if (this.#values.length > this.#limit) this.#values.shift();
  }

  /** The greatest value of all; 0 where there is none. */
  get greatest(): number {
    return Math.max(0, ...this.#values.map((value) => value ?? 0));
  }

  /**
   * Returns the data of two SVG paths in a box of the given size: the line, and the area under it. The newest value is
   * at the right edge; the lower edge is 0, so that a figure that hardly moves looks like one.
   *
   * @param top the value at the upper edge
   */
  paths(
    width: number,
    height: number,
    top: number = this.greatest * 1.25 || 1,
  ): { line: string; area: string } {
    const step = width / (this.#limit - 1);
    let line = "";
    let area = "";
    for (const run of this.#runs()) {
      const points = run.map(({ index, value }) => {
        const x = width - (this.#values.length - 1 - index) * step;
        return [x.toFixed(1), (height - (value / top) * height).toFixed(1)] as const;
      });
      const drawn = points.map(([x, y]) => `${x} ${y}`).join("L");
      const [from, to] = [points[0]?.[0], points.at(-1)?.[0]];
      line += `M${drawn}`;
      area += `M${from} ${height}L${drawn}L${to} ${height}Z`;
    }
    return { line, area };
  }

  /** Returns the unbroken stretches. */
  #runs(): { index: number; value: number }[][] {
    const runs: { index: number; value: number }[][] = [];
    this.#values.forEach((value, index) => {
      if (value === null) return;
      const run = runs.at(-1);
      if (run && run.at(-1)?.index === index - 1) run.push({ index, value });
      else runs.push([{ index, value }]);
    });
    return runs;
  }
}
