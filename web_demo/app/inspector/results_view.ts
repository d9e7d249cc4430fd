/** Results as a table: names, values as their types say, and the types. */

import type { Result } from "../../sdk/index.ts";
import { make } from "../dom/elements.ts";
import { copyButton } from "./controls.ts";
import { fieldKind, listItems } from "./value_text.ts";

export function resultsTable(results: readonly Result[]): HTMLElement {
  if (results.length === 0) return make("p", { class: "hint" }, "No results.");
  const rows = results.map(({ name, data_type_ref, value }) =>
    make(
      "div",
      { class: "result", "data-result": name },
      make("dt", {}, name),
      make("dd", {}, shownValue(data_type_ref, value)),
      make("span", { class: "type" }, data_type_ref),
      copyButton(`Copy ${name}`, () => value),
    ),
  );
  return make("dl", { class: "results" }, ...rows);
}

/** A value as one reads it: a list as its items, a time with what it is here, an empty text as such. */
function shownValue(code: string, text: string): Node {
  const kind = fieldKind(code);
  const items = kind === "list" ? listItems(text) : null;
  if (items?.length) {
    const written = items.map((item) => make("li", {}, item === "" ? "“”" : item));
    return make("ul", { class: "value items" }, ...written);
  }
  if (text === "" || items?.length === 0)
    return make("span", { class: "value hint" }, text === "" ? "empty" : "empty list");
  const value = make("span", { class: "value", "data-kind": kind }, text);
  const moment = kind === "time" ? new Date(text) : null;
  if (moment === null || Number.isNaN(moment.getTime())) return value;
  return make("span", {}, value, make("span", { class: "hint" }, ` ${moment.toLocaleString()}`));
}

/** The values of results in one line. */
export function gist(results: readonly Result[]): HTMLElement {
  const parts = results.flatMap(({ name, value }) => [
    make("span", { class: "gist-name" }, name),
    ` ${value === "" ? "“”" : value}   `,
  ]);
  return make("span", { class: "gist" }, ...parts);
}
