/** The floor as a drawing, seen from above, with the viewer below. */

import { drawn, extentOf, gridLines, turned } from "./geometry.ts";
import type { Extent, Place, Point, Thing } from "./geometry.ts";
import { placeLabels } from "./labels.ts";
import type { Label } from "./labels.ts";
import type { Target } from "./walk.ts";

const SVG = "http://www.w3.org/2000/svg";
/** How high letters are, in shares of what is shown. */
const LETTERS = 0.038;

export interface Ground {
  readonly outline: readonly Point[];
  readonly obstacles: readonly (readonly Point[])[];
}

export class FloorView {
  readonly element = draw("svg", {
    class: "map",
    "data-testid": "map",
    tabindex: "0",
    role: "application",
    "aria-label": "Floor, seen from above. The arrow keys move a cursor, Enter goes there.",
  });
  readonly #ground = draw("g", { class: "map-ground" });
  readonly #way = draw("polyline", { class: "map-way" });
  readonly #targets = draw("g", {});
  readonly #marks = draw("g", {});
  readonly #figure = draw(
    "g",
    { class: "map-figure", "data-testid": "map-figure" },
    draw("path", { class: "map-sight", d: "M0 0L.62-.4A.74.74 0 0 1 .62.4Z" }),
    draw("circle", { r: "0.2" }),
    draw("path", { class: "map-nose", d: "M-.06-.09L.1 0L-.06.09" }),
  );
  readonly #cursor = draw(
    "g",
    { class: "map-cursor" },
    draw("circle", { r: "0.16" }),
    draw("path", { d: "M-.3 0h.2M.1 0h.2M0-.3v.2M0 .1v.2" }),
  );
  readonly #known = new Map<string, SVGGElement>();
  #extent: Extent = { left: -1, top: -1, width: 2, height: 2 };
  #things: readonly Thing[] = [];
  #labels: ReadonlyMap<string, Label> = new Map();

  constructor() {
    this.element.append(this.#ground, this.#way, this.#targets, this.#marks, this.#figure, this.#cursor);
    this.#figure.style.display = this.#cursor.style.display = "none";
  }

  get extent(): Extent {
    return this.#extent;
  }

  /** @param others what is to be seen where there is no floor */
  showGround({ outline, obstacles }: Ground, others: readonly Point[]): void {
    const extent = extentOf(outline, others);
    const { left, top, width, height } = extent;
    this.#extent = extent;
    this.element.setAttribute("viewBox", `${left} ${top} ${width} ${height}`);
    this.element.style.setProperty("--letters", `${this.#letters.toFixed(3)}px`);
    this.#ground.replaceChildren(
      draw("polygon", { class: "map-floor", points: drawn(outline) }),
      draw("path", { class: "map-grid", d: gridLines(extent) }),
      draw("polygon", { class: "map-edge", points: drawn(outline) }),
      ...obstacles.map((corners) => draw("polygon", { class: "map-obstacle", points: drawn(corners) })),
    );
    this.#labels = new Map();
    this.#showNames();
  }

  /** Those that are known move to where they are now. */
  showThings(things: readonly Thing[]): void {
    this.#things = things;
    const refs = new Set(things.map(({ ref }) => ref));
    for (const [ref, mark] of this.#known) {
      if (refs.has(ref)) continue;
      mark.remove();
      this.#known.delete(ref);
    }
    for (const thing of things) {
      const mark = this.#known.get(thing.ref) ?? this.#mark(thing);
      put(mark, thing.place);
    }
    this.#showNames();
  }

  showFigure(place: Place | null): void {
    this.#figure.style.display = place ? "" : "none";
    if (place) put(this.#figure, place, `rotate(${turned(place.th)}deg)`);
    this.element.dataset["figure"] = place ? `${place.x.toFixed(2)},${place.y.toFixed(2)}` : "";
  }

  showWay(figure: Place | null, targets: readonly Target[]): void {
    const corners = [...(figure ? [figure] : []), ...targets.map(({ place }) => place)];
    this.#way.setAttribute("points", targets.length > 0 ? drawn(corners.map(({ x, y }) => [x, y])) : "");
    this.#targets.replaceChildren(
      ...targets.map(({ place }, index) => {
        const last = index === targets.length - 1;
        const mark = draw(
          "g",
          { class: last ? "map-target last" : "map-target" },
          draw("circle", { class: "map-ring", r: "0.17" }),
          draw("circle", { r: "0.06" }),
        );
        put(mark, place);
        return mark;
      }),
    );
  }

  showCursor(at: Point | null): void {
    this.#cursor.style.display = at ? "" : "none";
    if (at) put(this.#cursor, { x: at[0], y: at[1] });
  }

  /** Where in the scene a point of the window is; null while the drawing is not shown. */
  at(clientX: number, clientY: number): Point | null {
    const matrix = this.element.getScreenCTM();
    if (!matrix) return null;
    const { x, y } = new DOMPoint(clientX, clientY).matrixTransform(matrix.inverse());
    return [x, -y];
  }

  /** How high letters are, in metres of the drawing. */
  get #letters(): number {
    return LETTERS * Math.max(this.#extent.width, this.#extent.height);
  }

  /** Places the names beside their marks. */
  #showNames(): void {
    this.#labels = placeLabels(this.#things, this.#extent, this.#letters, this.#labels);
    for (const { ref, name } of this.#things) {
      const text = this.#known.get(ref)?.lastElementChild;
      const label = this.#labels.get(ref);
      if (!text || !label) continue;
      if (text.textContent !== name) text.textContent = name;
      text.setAttribute("x", label.x.toFixed(3));
      text.setAttribute("y", label.y.toFixed(3));
    }
  }

  #mark({ ref, kind }: Thing): SVGGElement {
    const shape =
      kind === "person"
        ? [draw("circle", { r: "0.19" })]
        : kind === "sound"
          ? [
              draw("circle", { r: "0.05" }),
              draw("path", {
                d: "M.1-.1a.14.14 0 0 1 0 .2M.18-.18a.25.25 0 0 1 0 .36M-.1-.1a.14.14 0 0 0 0 .2M-.18-.18a.25.25 0 0 0 0 .36",
              }),
            ]
          : [];
    const mark = draw("g", { class: `map-thing ${kind}` }, ...shape, draw("text", {}));
    this.#known.set(ref, mark);
    this.#marks.append(mark);
    return mark;
  }
}

function put(mark: SVGGElement, { x, y }: Pick<Place, "x" | "y">, more = ""): void {
  mark.style.transform = `translate(${x}px, ${-y}px) ${more}`;
}

function draw<K extends keyof SVGElementTagNameMap>(
  tag: K,
  attributes: Record<string, string>,
  ...children: Node[]
): SVGElementTagNameMap[K] {
  const element = document.createElementNS(SVG, tag);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
  element.append(...children);
  return element;
}
