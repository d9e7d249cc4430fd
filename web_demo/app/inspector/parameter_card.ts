/** The parameters of a component: as the engine has them, as they are typed, and the change from one to the other. */

import { RoISError } from "../../sdk/index.ts";
import type { ParameterProfile } from "../../sdk/index.ts";
import { make, setText } from "../dom/elements.ts";
import type { Card, ComponentBench } from "./component_bench.ts";
import { button, iconButton } from "./controls.ts";
import { RequestPreview } from "./message_head.ts";
import { OutcomeView } from "./outcome_view.ts";
import { completedWords, refusal, tookWords } from "./sentences.ts";
import { sameValue } from "./value_text.ts";
import type { ValueField } from "./value_field.ts";
import { ValueForm, valuesOf } from "./value_form.ts";

const KEY = "parameter";

export class ParameterCard implements Card {
  readonly element: HTMLFormElement;
  readonly #bench: ComponentBench;
  readonly #form: ValueForm;
  /** What the engine has; what is not there has no value. */
  #values = new Map<string, string>();
  readonly #set: HTMLButtonElement;
  readonly #revert: HTMLButtonElement;
  readonly #request: RequestPreview;
  readonly #reading = new OutcomeView();
  readonly #outcome = new OutcomeView();

  constructor(bench: ComponentBench, profiles: readonly ParameterProfile[]) {
    this.#bench = bench;
    this.#request = new RequestPreview("rois.command.set_parameter", () => ({
      component_ref: bench.ref,
      parameters: valuesOf(this.#changed),
    }));
    this.#form = new ValueForm(profiles, KEY, bench.drafts, "no value", () => {
      this.#outcome.clear();
      this.#render();
    });
    this.#set = make("button", { type: "submit", class: "button small run primary" });
    this.#revert = button("Revert", () => this.#revertAll(), "quiet");
    const reload = iconButton("reload", "Read the parameters again", () => void this.#read());
    reload.classList.add("run");
    this.element = make(
      "form",
      { class: "message", "data-kind": "parameters" },
      this.#reading.element,
      this.#form.element,
      this.#request.element,
      this.#outcome.element,
      make("div", { class: "form-end" }, reload, this.#request.toggle, this.#revert, this.#set),
    );
    this.element.addEventListener("submit", (event) => {
      event.preventDefault();
      this.#submit();
    });
    this.#render();
  }

  refresh(): void {
    void this.#read();
  }

  /** The fields that differ from what the engine has. */
  get #changed(): ValueField[] {
    return this.#form.fields.filter((field) => this.#bench.drafts.has(draftOf(field)));
  }

  async #read(): Promise<void> {
    try {
      const values = await this.#bench.client.getParameter(this.#bench.ref);
      this.#values = new Map(values.map(({ name, value }) => [name, value]));
      this.#reading.clear();
    } catch (error) {
      return this.#reading.refused(refusal("get_parameter", error));
    }
    const changed = new Set(this.#changed);
    for (const field of this.#form.fields) {
      field.mayBeEmpty = this.#valueOf(field) === "";
      // What the user is typing stays.
      if (!changed.has(field)) field.text = this.#valueOf(field);
    }
    this.#render();
  }

  #valueOf({ profile }: ValueField): string {
    return this.#values.get(profile.name) ?? "";
  }

  #revertAll(): void {
    for (const field of this.#changed) {
      this.#bench.drafts.delete(draftOf(field));
      field.text = this.#valueOf(field);
    }
    this.#outcome.clear();
    this.#render();
  }

  #submit(): void {
    const wrong = this.#changed.find((field) => field.check() !== null);
    if (!wrong) return void this.#send();
    wrong.focus();
    const anyway = button("Send it anyway", () => void this.#send(), "quiet");
    this.#outcome.refused({ code: "not sent", sentence: "A value does not fit its type." }, anyway);
  }

  async #send(): Promise<void> {
    const changed = this.#changed;
    if (changed.length === 0) return;
    const sent = valuesOf(changed);
    const startedAt = performance.now();
    this.#outcome.running("Setting");
    try {
      const id = await this.#bench.client.setParameter(this.#bench.ref, sent);
      this.#bench.onWork();
      const { status, reason } = await this.#bench.client.completed(id);
      const took = tookWords(performance.now() - startedAt);
      if (status !== "OK")
        return this.#outcome.ended(status, `${completedWords(status, reason)} (after ${took})`);
      // What was typed since then is another change.
      for (const field of changed) {
        const { value } = sent.find(({ name }) => name === field.profile.name) ?? {};
        if (field.text === value) this.#bench.drafts.delete(draftOf(field));
      }
      this.#outcome.done(`set and completed after ${took}`);
      await this.#read();
    } catch (error) {
      this.#outcome.refused(refusal("set_parameter", error), ...this.#remedies(error));
    }
  }

  #remedies(error: unknown): Node[] {
    if (!(error instanceof RoISError && error.returnCode === "OUT_OF_RESOURCES")) return [];
    const bindAndSend = async (): Promise<void> => {
      try {
        await this.#bench.bind();
      } catch (refused) {
        return this.#outcome.refused(refusal("bind", refused));
      }
      await this.#send();
    };
    return [button("Bind and set", () => void bindAndSend(), "quiet")];
  }

  #render(): void {
    for (const field of this.#form.fields) {
      // Typed back to what the engine has: that is no change.
      if (sameValue(field.profile.data_type_ref.code, field.text, this.#valueOf(field)))
        this.#bench.drafts.delete(draftOf(field));
    }
    const changed = this.#changed;
    for (const field of this.#form.fields) field.element.classList.toggle("changed", changed.includes(field));
    this.#set.disabled = changed.length === 0;
    this.#revert.hidden = changed.length === 0;
    setText(this.#set, changed.length < 2 ? "Set parameter" : `Set ${changed.length} parameters`);
    this.#request.render();
  }
}

const draftOf = ({ profile }: ValueField): string => `${KEY}/${profile.name}`;
