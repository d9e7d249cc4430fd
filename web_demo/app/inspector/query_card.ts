/** One query: asked, answered, and how long that took. */

import { onlyComponent } from "../../sdk/index.ts";
import type { EventMessageProfile } from "../../sdk/index.ts";
import { make } from "../dom/elements.ts";
import { formatTime } from "../model/format.ts";
import type { Card, ComponentBench } from "./component_bench.ts";
import { RequestPreview, messageHead } from "./message_head.ts";
import { OutcomeView } from "./outcome_view.ts";
import { refusal, tookWords } from "./sentences.ts";

export class QueryCard implements Card {
  readonly element: HTMLFormElement;
  readonly #bench: ComponentBench;
  readonly #name: string;
  readonly #outcome = new OutcomeView();
  #asking = false;

  constructor(bench: ComponentBench, { name, results = [] }: EventMessageProfile) {
    this.#bench = bench;
    this.#name = name;
    const condition = onlyComponent(bench.ref);
    const request = new RequestPreview("rois.query.query", () => ({ query_type: name, condition }));
    const run = make("button", { type: "submit", class: "button small run" }, "Ask");
    run.append(make("span", { class: "visually-hidden" }, ` ${name}`));
    this.element = make(
      "form",
      { class: "message", "data-kind": "query", "data-name": name },
      messageHead(name, results, [], request.toggle, run),
      request.element,
      this.#outcome.element,
    );
    this.element.addEventListener("submit", (event) => {
      event.preventDefault();
      void this.#ask();
    });
  }

  async #ask(): Promise<void> {
    if (this.#asking) return;
    this.#asking = true;
    this.element.setAttribute("aria-busy", "true");
    const startedAt = performance.now();
    try {
      const results = await this.#bench.client.query(this.#name, onlyComponent(this.#bench.ref));
      const took = tookWords(performance.now() - startedAt);
      this.#outcome.done(`answered in ${took} at ${formatTime(Date.now())}`, results);
    } catch (error) {
      this.#outcome.refused(refusal("query", error));
    } finally {
      this.#asking = false;
      this.element.removeAttribute("aria-busy");
    }
  }
}
