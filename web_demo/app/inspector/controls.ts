/** Small controls of the inspector. */

import { make, setText } from "../dom/elements.ts";
import { drawing } from "./icons.ts";
import type { IconName } from "./icons.ts";

/** Milliseconds for which a copied thing says so. */
const COPIED_SHOWN = 1200;

export function button(label: string, onPress: () => void, ...classes: string[]): HTMLButtonElement {
  const element = make("button", { type: "button", class: ["button", "small", ...classes].join(" ") }, label);
  element.addEventListener("click", onPress);
  return element;
}

/** Makes a button with a drawing; the label is its name for screen readers and its tooltip. */
export function iconButton(name: IconName, label: string, onPress: () => void): HTMLButtonElement {
  const attributes = { type: "button", class: "icon-button", "aria-label": label, title: label };
  const element = make("button", attributes, drawing(name));
  element.addEventListener("click", onPress);
  return element;
}

/** Copies a text, and says for a moment whether it did. */
export function copyButton(label: string, text: () => string): HTMLButtonElement {
  const element = iconButton("copy", label, () => void copy());
  element.classList.add("copy");
  const show = (name: IconName, words: string): void => {
    element.replaceChildren(drawing(name));
    element.title = words;
    element.setAttribute("aria-label", words);
  };
  const copy = async (): Promise<void> => {
    const copied = await navigator.clipboard?.writeText(text()).then(
      () => true,
      () => false,
    );
    show(copied ? "check" : "remove", copied ? "Copied" : "The browser does not let the page copy");
    setTimeout(() => show("copy", label), COPIED_SHOWN);
  };
  return element;
}

/** A value as coloured JSON, which can be copied. */
export function jsonBlock(value: unknown, label: string): HTMLElement {
  const pieces = jsonPieces(value).map(({ kind, text }) =>
    kind === "plain" ? text : make("span", { class: `json-${kind}` }, text),
  );
  const block = make("pre", { tabindex: "0", role: "group", "aria-label": label }, ...pieces);
  return make(
    "div",
    { class: "json" },
    block,
    copyButton("Copy as JSON", () => block.textContent),
  );
}

/** A part of the page that is written when it is opened, and anew each time. */
export function disclosure(title: string, content: () => Node): HTMLDetailsElement {
  const body = make("div", { class: "disclosed" });
  const element = make("details", { class: "disclosure" }, make("summary", {}, title), body);
  element.addEventListener("toggle", () => body.replaceChildren(...(element.open ? [content()] : [])));
  return element;
}

/** A number beside a title; 0 shows none. */
export function showCount(element: HTMLElement, count: number): void {
  element.hidden = count === 0;
  setText(element, String(count));
}

/** Makes `parent` hold exactly these elements, in this order, and lets those that stay keep the keyboard's focus. */
export function arrange(parent: Element, elements: readonly Element[]): void {
  const wanted = new Set(elements);
  for (const child of [...parent.children]) if (!wanted.has(child)) child.remove();
  for (const [index, element] of elements.entries()) {
    const there = parent.children[index];
    if (there !== element) parent.insertBefore(element, there ?? null);
  }
}

export interface JsonPiece {
  readonly kind: "name" | "string" | "literal" | "plain";
  readonly text: string;
}

const TOKEN = /("(?:[^"\\]|\\.)*")(\s*:)?|-?\d+(?:\.\d+)?(?:[eE][+-]?\d+)?|\b(?:true|false|null)\b/g;

/** Returns the pieces of a value's indented text; together they are that text. */
export function jsonPieces(value: unknown): JsonPiece[] {
  const text = JSON.stringify(value, null, 2) ?? "";
  const pieces: JsonPiece[] = [];
  let end = 0;
  const plain = (until: number): void => {
    if (until > end) pieces.push({ kind: "plain", text: text.slice(end, until) });
  };
  for (const match of text.matchAll(TOKEN)) {
    plain(match.index);
    const [whole, string, colon] = match;
    const kind = string === undefined ? "literal" : colon === undefined ? "string" : "name";
    pieces.push({ kind, text: string ?? whole });
    end = match.index + (string ?? whole).length;
  }
  plain(text.length);
  return pieces;
}
