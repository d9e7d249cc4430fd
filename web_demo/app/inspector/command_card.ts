/** One command: its arguments, and its latest runs, each from `execute` to `completed` and its results. */

import { RoISError } from "../../sdk/index.ts";
import type { CommandMessageProfile, Command } from "../../sdk/index.ts";
import { make } from "../dom/elements.ts";
import { formatTime } from "../model/format.ts";
import type { Card, ComponentBench } from "./component_bench.ts";
import { button } from "./controls.ts";
import { RequestPreview, messageHead } from "./message_head.ts";
import { OutcomeView } from "./outcome_view.ts";
import { completedWords, limitWords, refusal, tookWords } from "./sentences.ts";
import { ValueForm } from "./value_form.ts";

/** Most runs shown; running ones always are. */
const RUNS_SHOWN = 4;

export class CommandCard implements Card {
  readonly element: HTMLFormElement;
  readonly #bench: ComponentBench;
  readonly #name: string;
  readonly #form: ValueForm;
  readonly #misfit = new OutcomeView();
  readonly #runs = make("ol", { class: "runs" });

  constructor(bench: ComponentBench, profile: CommandMessageProfile) {
    const { name, arguments: arguments_ = [], results = [], timeout } = profile;
    this.#bench = bench;
    this.#name = name;
    const request = new RequestPreview("rois.command.execute", () => ({
      command_unit_list: [{ ...this.#unit(), command_id: "…" }],
    }));
    this.#form = new ValueForm(arguments_, `command/${name}`, bench.drafts, "left out", () => {
      this.#misfit.clear();
      request.render();
    });
    const run = make("button", { type: "submit", class: "button small run" }, "Execute");
    run.append(make("span", { class: "visually-hidden" }, ` ${name}`));
    const limit = typeof timeout === "number" ? [`within ${limitWords(timeout)}`] : [];
    this.element = make(
      "form",
      { class: "message", "data-kind": "command", "data-name": name },
      messageHead(name, results, limit, request.toggle, run),
      this.#form.element,
      request.element,
      this.#misfit.element,
      this.#runs,
    );
    this.element.addEventListener("submit", (event) => {
      event.preventDefault();
      if (this.#form.focusProblem()) this.#askWhether();
      else void this.#execute();
    });
  }

  #unit(): Command {
    const { values } = this.#form;
    const unit = { component_ref: this.#bench.ref, command_type: this.#name };
    return values.length === 0 ? unit : { ...unit, arguments: values };
  }

  /** Offers to send values that do not fit: the engine's answer may be what the user wants to see. */
  #askWhether(): void {
    const anyway = button("Send it anyway", () => void this.#execute(), "quiet");
    this.#misfit.refused({ code: "not sent", sentence: "A value does not fit its type." }, anyway);
  }

  async #execute(): Promise<void> {
    this.#misfit.clear();
    const outcome = this.#newRun();
    const { client } = this.#bench;
    const startedAt = performance.now();
    const took = (): string => tookWords(performance.now() - startedAt);
    outcome.running("Sent");
    try {
      const [id = ""] = await client.execute([this.#unit()]);
      outcome.running(`Running since ${formatTime(Date.now())}`);
      this.#bench.onWork();
      const { status, reason } = await client.completed(id);
      if (status !== "OK")
        return outcome.ended(status, `${completedWords(status, reason)} (after ${took()})`);
      const words = `completed after ${took()}`;
      outcome.done(words);
      const results = await client.getCommandResult(id);
      if (results.length > 0) outcome.done(words, results);
    } catch (error) {
      outcome.refused(refusal("execute", error), ...this.#remedies(error));
    } finally {
      this.#bench.onWork();
    }
  }

  #remedies(error: unknown): Node[] {
    if (!(error instanceof RoISError && error.returnCode === "OUT_OF_RESOURCES")) return [];
    const bindAndRun = async (): Promise<void> => {
      try {
        // What is stopped while it is being bound is not executed afterwards; it stays bound, as "Bind" alone would leave it.
        await this.#bench.client.control.unlessStopped(this.#bench.ref, () => this.#bench.bind());
      } catch (refused) {
        return this.#newRun().refused(refusal("bind", refused));
      }
      await this.#execute();
    };
    return [button("Bind and execute", () => void bindAndRun(), "quiet")];
  }

  #newRun(): OutcomeView {
    const outcome = new OutcomeView();
    this.#runs.prepend(make("li", {}, outcome.element));
    const ended = [...this.#runs.children].filter((run) => !run.querySelector("[data-state=running]"));
    for (const run of ended.slice(RUNS_SHOWN)) run.remove();
    return outcome;
  }
}
