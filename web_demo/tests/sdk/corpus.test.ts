/** The corpus of messages that every language reads: the schema judges as it does, and so does this SDK. */

import { readFileSync, readdirSync } from "node:fs";
import Ajv2020 from "ajv/dist/2020.js";
import { describe, expect, it } from "vitest";
import { ValueError } from "../../sdk/rois/errors.ts";
import { decodeValue, encodeValue } from "../../sdk/rois/values.ts";
import type { Value } from "../../sdk/rois/values.ts";
import { wrongInNotification, wrongInResult } from "../../sdk/rois/checks.ts";

interface Case {
  readonly name: string;
  readonly message: unknown;
  /** What is wrong with it; absent where nothing is. */
  readonly kind?: string;
}

interface Corpus {
  readonly type: string;
  readonly valid: readonly Case[];
  readonly invalid: readonly Case[];
}

interface Reference {
  readonly $ref: string;
}

/** The OpenRPC document, as far as it says which type is what. */
interface Wire {
  readonly methods: readonly { readonly name: string; readonly result: { readonly schema: Reference } }[];
  readonly "x-notifications": readonly { readonly name: string; readonly "x-params": Reference }[];
}

const VERSION = "2026-11-21";
const ROOT = new URL("../../../", import.meta.url);
const read = (path: string): string => readFileSync(new URL(path, ROOT), "utf8");

const folder = `tests/corpus/${VERSION}/`;
const corpus: Corpus[] = readdirSync(new URL(folder, ROOT))
  .filter((name) => name.endsWith(".json"))
  .map((name) => JSON.parse(read(folder + name)));
const casesOf = (type: string): readonly Case[] => {
  const found = corpus.find((each) => each.type === type);
  if (!found) throw new Error(`the corpus has no ${type}`);
  return [...found.valid, ...found.invalid];
};

/** The names of the cases on which `accepts` does not judge as the corpus does. */
const misjudged = (type: string, expected: (each: Case) => boolean, accepts: (message: unknown) => boolean) =>
  casesOf(type)
    .filter((each) => accepts(each.message) !== expected(each))
    .map(({ name }) => name);

describe("the JSON Schema", () => {
  const schema: { readonly $id: string } = JSON.parse(read(`openrois/schema/${VERSION}/rois.schema.json`));
  const ajv = new Ajv2020({ strict: false, schemas: [schema] });

  it.each(corpus.map(({ type }) => type))("%s", (type) => {
    const validate = ajv.getSchema(`${schema.$id}#/$defs/${type}`);
    if (!validate) throw new Error(`the schema has no ${type}`);
    // A rule over several fields has no place in a schema.
    const judged = misjudged(
      type,
      ({ kind }) => kind === undefined || kind === "rule",
      (message) => validate(message) === true,
    );
    expect(judged).toEqual([]);
  });
});

/** What the SDK relies on; it passes over members that it does not know, and lengths and other limits. */
const passed = ({ kind }: Case): boolean => kind === undefined || ["unknown", "range", "rule"].includes(kind);
const wire: Wire = JSON.parse(read(`openrois/schema/${VERSION}/openrpc.json`));
const typeOf = ({ $ref }: Reference): string => $ref.split("/").at(-1) ?? "";

describe("what comes in", () => {
  it.each(wire.methods.map(({ name, result }) => [name, typeOf(result.schema)] as const))(
    "in answer to %s is a %s",
    (method, type) => {
      expect(misjudged(type, passed, (message) => wrongInResult(method, message) === null)).toEqual([]);
    },
  );

  it.each(wire["x-notifications"].map((each) => [each.name, typeOf(each["x-params"])] as const))(
    "with %s is a %s",
    (method, type) => {
      expect(misjudged(type, passed, (message) => wrongInNotification(method, message) === null)).toEqual([]);
    },
  );
});

interface Text {
  readonly type: string;
  readonly text: string;
}

interface Values {
  readonly valid: readonly (Text & { readonly value: Value })[];
  readonly invalid: readonly Text[];
}

describe("texts of values", () => {
  const values: Values = JSON.parse(read(`${folder}values/values.json`));
  /** JSON in JavaScript cannot tell 1.0 from 1. */
  const same = ({ type, text }: Text): boolean =>
    type.toLowerCase().startsWith("int") && /\d\.0\b/.test(text);

  it.each(values.valid)("$type $text", ({ type, text, value }) => {
    expect(decodeValue(type, text)).toEqual(value);
    // A status that is none is read as the text it is, and not written.
    if (text === "of another version") expect(() => encodeValue(type, value)).toThrow(ValueError);
    else expect(decodeValue(type, encodeValue(type, value))).toEqual(value);
  });

  it.each(values.invalid.filter((each) => !same(each)))("not $type $text", ({ type, text }) => {
    expect(() => decodeValue(type, text)).toThrow(ValueError);
  });
});
