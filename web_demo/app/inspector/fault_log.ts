/** Errors notified by engines and components, with their details. */

import { engineOf } from "../../sdk/index.ts";
import type { Client, Result } from "../../sdk/index.ts";
import { make } from "../dom/elements.ts";
import { formatTime } from "../model/format.ts";
import { codeChip } from "./outcome_view.ts";
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

/** Keeps notified errors and asks for their details at once, since engines drop them after a while. */
export class FaultLog {
  readonly #client: Client;
  readonly #onChange: () => void;
  #faults: Fault[] = [];

  constructor(client: Client, onChange: () => void) {
    this.#client = client;
    this.#onChange = onChange;
    client.on("fault", ({ error_id, error_type }) => void this.#addFault(error_id, error_type));
  }

  /** Returns the errors of an engine, or those whose details name a component; the newest first. */
  about(id: string): readonly Fault[] {
    return this.#faults.filter((fault) => isAbout(fault, id));
  }

  async #addFault(errorId: string, errorType: string): Promise<void> {
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

export function faultRow({ errorType, at, detail }: Fault): HTMLElement {
  const summary = make(
    "summary",
    {},
    make("time", {}, formatTime(at)),
    codeChip(errorType),
    make("span", { class: "gist" }, detail instanceof Array ? gist(detail) : ""),
  );
  const known =
    detail === null
      ? make("p", { class: "hint" }, "Asking for its details")
      : "code" in detail
        ? make("p", { class: "hint" }, detail.sentence)
        : resultsTable(detail);
  const body = make("div", { class: "detail" }, known);
  return make("li", { "data-error": errorType }, make("details", {}, summary, body));
}

/** Returns the texts of an error's details, without references, kinds and times. */
function gist(detail: readonly Result[]): string {
  const texts = detail.filter(({ data_type_ref }) => data_type_ref.toLowerCase() === "string");
  return texts.map(({ value }) => value).join("  ");
}
