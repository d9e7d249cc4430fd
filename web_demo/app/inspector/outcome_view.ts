/** Outcome of a call: running, done with results, or refused with a sentence. */

import type { Result } from "../../sdk/index.ts";
import { make } from "../dom/elements.ts";
import { codeWords } from "../model/code_words.ts";
import { sentence } from "../model/plain_words.ts";
import { copyButton } from "./controls.ts";
import { resultsTable } from "./results_view.ts";
import type { Refusal } from "./sentences.ts";

export type OutcomeState = "running" | "done" | "ended" | "refused";

/** Box with one outcome at a time, announced to screen readers. */
export class OutcomeView {
  readonly element = make("div", { class: "outcome", role: "status", hidden: "" });

  clear(): void {
    this.element.hidden = true;
    this.element.replaceChildren();
  }

  running(words: string): void {
    this.#show("running", make("p", {}, words));
  }

  /** @param results null where there is nothing that could have any */
  done(words: string, results: readonly Result[] | null = null): void {
    const line = codeLine("OK", words);
    if (results?.length)
      line.append(copyButton("Copy the results as JSON", () => JSON.stringify(results, null, 2)));
    this.#show("done", line, ...(results ? [resultsTable(results)] : []));
  }

  /** A command that was accepted and did not end well. */
  ended(code: string, words: string): void {
    this.#show("ended", codeLine(code, words));
  }

  refused({ code, sentence }: Refusal, ...remedies: Node[]): void {
    this.#show("refused", codeLine(code, sentence, ...remedies));
  }

  #show(state: OutcomeState, ...children: Node[]): void {
    this.element.dataset["state"] = state;
    this.element.hidden = false;
    this.element.replaceChildren(...children);
  }
}

function codeLine(code: string, words: string, ...remedies: Node[]): HTMLElement {
  const attributes = { class: "outcome-line" };
  return make("p", attributes, codeChip(code), make("span", {}, words), ...remedies);
}

/** Makes the label of a code; its tooltip has the code itself, for programmers. */
export function codeChip(code: string): HTMLElement {
  const words = sentence(codeWords(code));
  const title: Record<string, string> =
    words.toUpperCase() === code.toUpperCase() ? {} : { title: `Code ${code}` };
  return make("span", { class: "code", ...title }, words);
}
