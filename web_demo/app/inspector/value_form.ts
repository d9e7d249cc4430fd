/** The fields of one message or of a component's parameters. */

import type { ParameterProfile, Result } from "../../sdk/index.ts";
import { make } from "../dom/elements.ts";
import { ValueField } from "./value_field.ts";

/** What was typed, by field: it outlives the fields, which are made anew when their profile changes. */
export type Drafts = Map<string, string>;

export class ValueForm {
  readonly element: HTMLElement;
  readonly fields: readonly ValueField[];

  /**
   * @param key of the message; leads its drafts' keys
   * @param empty what an empty field means, in words
   */
  constructor(
    profiles: readonly ParameterProfile[],
    key: string,
    drafts: Drafts,
    empty: string,
    onChange: () => void,
  ) {
    this.fields = profiles.map((profile) => {
      const draft = `${key}/${profile.name}`;
      const field = new ValueField(profile, empty, () => {
        drafts.set(draft, field.text);
        onChange();
      });
      field.text = drafts.get(draft) ?? "";
      return field;
    });
    this.element = make("div", { class: "fields" }, ...this.fields.map(({ element }) => element));
    this.element.hidden = profiles.length === 0;
  }

  /** The values that are there, with their types; an empty one is left out. */
  get values(): Result[] {
    return valuesOf(this.fields.filter(({ text }) => text !== ""));
  }

  /** Goes to the first field that is wrong; false when none is. */
  focusProblem(): boolean {
    const wrong = this.fields.find((field) => field.check() !== null);
    wrong?.focus();
    return wrong !== undefined;
  }
}

export function valuesOf(fields: readonly ValueField[]): Result[] {
  return fields.map(({ profile, text }) => ({
    name: profile.name,
    data_type_ref: profile.data_type_ref.code,
    value: text,
  }));
}
