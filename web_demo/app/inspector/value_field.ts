/** One value that is typed or chosen, as its type wants it, with what is wrong beside it. */

import { ComponentStatus } from "../../sdk/index.ts";
import type { ParameterProfile } from "../../sdk/index.ts";
import { make, setText } from "../dom/elements.ts";
import { button } from "./controls.ts";
import { ListEditor } from "./list_editor.ts";
import { fieldKind, misfit, sameValue } from "./value_text.ts";
import type { FieldKind } from "./value_text.ts";

/** What a text is typed into, whatever it looks like. */
export interface Editor {
  readonly element: HTMLElement;
  text: string;
  focus(): void;
}

let fields = 0;

export class ValueField {
  readonly element: HTMLElement;
  readonly profile: ParameterProfile;
  readonly #editor: Editor;
  readonly #problem: HTMLElement;
  readonly #default: HTMLElement;
  /** An empty text says that there is no value; otherwise it has to fit the type as any other. */
  mayBeEmpty = true;

  /** @param empty what an empty text means, in words */
  constructor(profile: ParameterProfile, empty: string, onChange: () => void) {
    this.profile = profile;
    const id = `field-${++fields}`;
    this.#problem = make("p", { class: "problem", id: `${id}-problem`, "aria-live": "polite" });
    this.#editor = makeEditor(profile, id, empty, () => {
      this.check();
      onChange();
    });
    const { name, description = "", default_value = "", data_type_ref } = profile;
    this.#default = make("span", {}, `Default: ${default_value}`);
    const about = make(
      "div",
      { class: "field-about" },
      // A list has many fields and is a group with this name.
      fieldKind(data_type_ref.code) === "list"
        ? make("span", { class: "label", id: `${id}-label` }, name)
        : make("label", { class: "label", for: id }, name),
      make("span", { class: "type" }, data_type_ref.code),
    );
    const note = make("p", { class: "hint field-note" }, make("span", {}, description), this.#default);
    const side = make("div", { class: "field-value" }, this.#editor.element, this.#problem, note);
    this.element = make(
      "div",
      { class: "field", "data-field": name, "data-kind": fieldKind(data_type_ref.code) },
      about,
      side,
    );
  }

  get text(): string {
    return this.#editor.text;
  }

  set text(text: string) {
    if (this.#editor.text !== text) this.#editor.text = text;
    this.check();
  }

  focus(): void {
    this.#editor.focus();
  }

  /** Shows and returns what is wrong with the text; null when nothing is. */
  check(): string | null {
    const { text } = this;
    const { code } = this.profile.data_type_ref;
    const problem = text === "" && this.mayBeEmpty ? null : misfit(code, text);
    setText(this.#problem, problem ?? "");
    // What has its default value need not say so.
    const { default_value = "" } = this.profile;
    this.#default.hidden = default_value === "" || sameValue(code, text, default_value);
    this.element.classList.toggle("invalid", problem !== null);
    return problem;
  }
}

function makeEditor(profile: ParameterProfile, id: string, empty: string, onChange: () => void): Editor {
  const { code } = profile.data_type_ref;
  const kind = fieldKind(code);
  switch (kind) {
    case "list":
      return new ListEditor(code, id, onChange);
    case "truth":
      return choice(id, empty, ["true", "false"], onChange);
    case "status":
      return choice(id, empty, ComponentStatus, onChange);
    case "time":
      return moment(id, onChange);
    default:
      return line(id, kind, empty, onChange);
  }
}

const described = (id: string): Record<string, string> => ({ id, "aria-describedby": `${id}-problem` });

function line(id: string, kind: FieldKind, empty: string, onChange: () => void): Editor {
  const modes: Partial<Record<FieldKind, string>> = { integer: "numeric", number: "decimal" };
  const attributes = {
    ...described(id),
    spellcheck: "false",
    autocomplete: "off",
    inputmode: modes[kind] ?? "text",
    placeholder: empty,
  };
  // A text may have several lines; a number has one.
  const field =
    kind in modes
      ? make("input", { ...attributes, type: "text" })
      : make("textarea", { ...attributes, rows: "1" });
  field.addEventListener("input", onChange);
  field.addEventListener("keydown", (event) => {
    const key = event as KeyboardEvent;
    if (key.key !== "Enter" || key.shiftKey || key.isComposing || field instanceof HTMLInputElement) return;
    key.preventDefault();
    field.form?.requestSubmit();
  });
  return editorOf(field, field);
}

function choice(id: string, empty: string, values: readonly string[], onChange: () => void): Editor {
  const options = ["", ...values].map((value) => make("option", { value }, value === "" ? empty : value));
  const select = make("select", described(id), ...options);
  select.addEventListener("change", onChange);
  return {
    element: select,
    get text() {
      return select.value;
    },
    set text(text) {
      // What the engine says is shown, also when it should not say it.
      if (![...select.options].some(({ value }) => value === text))
        select.append(make("option", { value: text }, text));
      select.value = text;
    },
    focus: () => select.focus(),
  };
}

function moment(id: string, onChange: () => void): Editor {
  const attributes = { ...described(id), type: "text", spellcheck: "false", autocomplete: "off" };
  const input = make("input", { ...attributes, placeholder: "2026-06-01T12:00:00Z" });
  input.addEventListener("input", onChange);
  const now = button("Now", () => {
    input.value = new Date().toISOString();
    onChange();
  });
  return editorOf(make("div", { class: "joined" }, input, now), input);
}

function editorOf(element: HTMLElement, field: HTMLInputElement | HTMLTextAreaElement): Editor {
  return {
    element,
    get text() {
      return field.value;
    },
    set text(text) {
      field.value = text;
    },
    focus: () => field.focus(),
  };
}
