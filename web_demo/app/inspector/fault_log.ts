/** The errors that engines and components have notified, each with what the engine tells of it. */

import { engineOf } from "../../sdk/index.ts";
import type { Client, Result } from "../../sdk/index.ts";
import { make } from "../dom/elements.ts";
import { formatTime } from "../model/format.ts";
import { resultsTable } from "./results_view.ts";
import { refusal } from "./sentences.ts";
import type { Refusal } from "./sentences.ts";

/** How many errors are kept. */
export const FAULTS_KEPT = 100;

export interface Fault {
  readonly errorId: string;
  readonly errorType: string;
  readonly at: number;
  detail: readonly Result[] | Refusal | null;
}

/** Asks for the details of every error that is notified, since they are not kept for ever. */
export class FaultLog {
  readonly #client: Client;
  readonly #onChange: () => void;
  #faults: Fault[] = [];

  constructor(client: Client, onChange: () => void) {
    this.#client = client;
    this.#onChange = onChange;
    client.on("fault", ({ error_id, error_type }) => void this.#take(error_id, error_type));
  }

  /** The errors that the details of which name a component or engine, or that come from it; the newest first. */
  about(id: string): readonly Fault[] {
    return this.#faults.filter((fault) => isAbout(fault, id));
  }

  async #take(errorId: string, errorType: string): Promise<void> {
    const fault: Fault = { errorId, errorType, at: Date.now(), detail: null };
    this.#faults = [fault, ...this.#faults].slice(0, FAULTS_KEPT);
    this.#onChange();
    try {
      fault.detail = await this.#client.getErrorDetail(errorId);
    } catch (error) {
      fault.detail = refusal("error detail", error);
    }
    this.#onChange();
  }
}

function isAbout({ errorId, detail }: Fault, id: string): boolean {
  if (!id.includes("/")) return engineOf(errorId) === id;
  return detail instanceof Array && detail.some(({ value }) => value === id);
}

export function faultRow({ errorId, errorType, at, detail }: Fault): HTMLElement {
  const summary = make(
    "summary",
    {},
    make("time", {}, formatTime(at)),
    make("span", { class: "code" }, errorType),
    make("span", { class: "gist" }, detail instanceof Array ? told(detail) : ""),
  );
  const known =
    detail === null
      ? make("p", { class: "hint" }, "Asking for its details")
      : "code" in detail
        ? make("p", { class: "hint" }, `${detail.code}: ${detail.sentence}`)
        : resultsTable(detail);
  const ids = make("p", { class: "hint ids" }, make("span", {}, errorId));
  const body = make("div", { class: "detail" }, known, ids);
  return make("li", { "data-error": errorType }, make("details", {}, summary, body));
}

/** What is told for people: texts, not references, kinds and times. */
function told(detail: readonly Result[]): string {
  const texts = detail.filter(({ data_type_ref }) => data_type_ref.toLowerCase() === "string");
  return texts.map(({ value }) => value).join("  ");
}
