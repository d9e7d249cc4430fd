/** Stand-ins for the elements of the page, for tests without a browser. */

import { vi } from "vitest";

export class FakeElement extends EventTarget {
  hidden = false;
  disabled = false;
  textContent = "";
  title = "";
  tabIndex = 0;
  readonly dataset: Record<string, string> = {};
  readonly style = { setProperty: () => undefined };
  readonly classList = { toggle: () => undefined };
  readonly #attributes = new Map<string, string>();
  readonly #selector: string;

  constructor(selector = "") {
    super();
    this.#selector = selector;
  }

  setAttribute(name: string, value: string): void {
    this.#attributes.set(name, value);
  }

  getAttribute(name: string): string | null {
    return this.#attributes.get(name) ?? null;
  }

  removeAttribute(name: string): void {
    this.#attributes.delete(name);
  }

  /** Knows lists of simple selectors, and compares them with that by which it was found. */
  matches(selectors: string): boolean {
    const own = this.#selector === "input" ? "input:not([type])" : this.#selector;
    return selectors.split(",").includes(own);
  }

  append(): void {}

  replaceChildren(): void {}

  focus(): void {}

  click(): void {
    this.dispatchEvent(new Event("click"));
  }
}

/** Puts up a page on which every element can be found that is looked for; returns how. */
export function stubPage(): (testId: string) => FakeElement {
  const elements = new Map<string, FakeElement>();
  const find = (selector: string): FakeElement => {
    const element = elements.get(selector) ?? new FakeElement(selector);
    elements.set(selector, element);
    return element;
  };
  vi.stubGlobal("HTMLElement", FakeElement);
  vi.stubGlobal("HTMLButtonElement", FakeElement);
  vi.stubGlobal("addEventListener", () => undefined);
  vi.stubGlobal("navigator", {});
  vi.stubGlobal("matchMedia", () => ({ matches: false }));
  const page = Object.assign(new EventTarget(), {
    querySelector: find,
    createElement: () => new FakeElement(),
    createElementNS: () => new FakeElement(),
  });
  vi.stubGlobal("document", page);
  return (testId) => find(`[data-testid="${testId}"]`);
}
