/** What an event or an error is known by, and its details as the engine remembers them. */

import type { Client, RoISEvent } from "../../sdk/index.ts";
import { make } from "../dom/elements.ts";
import { button } from "./controls.ts";
import { OutcomeView } from "./outcome_view.ts";
import { resultsTable } from "./results_view.ts";
import { refusal } from "./sentences.ts";

/** An event that was opened: what came with it, and a button that asks for what the engine still knows. */
export function eventDetail(client: Client, event: RoISEvent): HTMLElement {
  const outcome = new OutcomeView();
  const ask = async (): Promise<void> => {
    try {
      outcome.done("the engine remembers", await client.getEventDetail(event.event_id));
    } catch (error) {
      outcome.refused(refusal("detail", error));
    }
  };
  const known = make(
    "p",
    { class: "hint ids" },
    make("span", {}, event.event_id),
    ...(event.expire === ""
      ? []
      : [make("span", {}, `details until ${new Date(event.expire).toLocaleTimeString()}`)]),
  );
  const asking = button("Ask for its details", () => void ask());
  // An engine that sends no results along has them in the details alone.
  if (event.results.length === 0) void ask();
  return make("div", { class: "detail" }, resultsTable(event.results), known, asking, outcome.element);
}
