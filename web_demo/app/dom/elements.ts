/** Finding and making elements. */

/** @throws Error when the page has no such element, which only a mistake in it can cause. */
function one<T extends Element>(selector: string, type: new () => T, root: ParentNode): T {
  const element = root.querySelector(selector);
  if (!(element instanceof type)) throw new Error(`the page has no ${type.name} ${selector}`);
  return element;
}

/** Returns the element that the page and its tests know by this name. */
export function byTestId<T extends Element>(name: string, type: new () => T, root: ParentNode = document): T {
  return one(`[data-testid="${name}"]`, type, root);
}

/** Returns the element that only the page itself knows by this name. */
export function byRole<T extends Element>(name: string, type: new () => T, root: ParentNode = document): T {
  return one(`[data-role="${name}"]`, type, root);
}

/** Makes an element. Children that are text become text, never markup. */
export function make<K extends keyof HTMLElementTagNameMap>(
  tag: K,
  attributes: Record<string, string> = {},
  ...children: (Node | string)[]
): HTMLElementTagNameMap[K] {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
  element.append(...children);
  return element;
}

/** Makes a line drawing of 24 x 24 units from the data of its paths. */
export function icon(...paths: string[]): SVGSVGElement {
  const svg = document.createElementNS("http://www.w3.org/2000/svg", "svg");
  svg.setAttribute("viewBox", "0 0 24 24");
  svg.setAttribute("aria-hidden", "true");
  for (const data of paths) {
    const line = document.createElementNS("http://www.w3.org/2000/svg", "path");
    line.setAttribute("d", data);
    svg.append(line);
  }
  return svg;
}

const LETTERS = ["text", "search", "url", "email", "tel", "password", "number"].map(
  (type) => `input[type=${type}]`,
);
const TEXT_FIELDS = ["textarea", "input:not([type])", ...LETTERS].join();

/** Whether letters that are typed at this element become text. */
export function takesLetters(target: EventTarget | null): boolean {
  return target instanceof HTMLElement && (target.isContentEditable || target.matches(TEXT_FIELDS));
}

/** Sets a text only when it differs, so that screen readers do not read it twice. */
export function setText(element: Element, text: string): void {
  if (element.textContent !== text) element.textContent = text;
}
