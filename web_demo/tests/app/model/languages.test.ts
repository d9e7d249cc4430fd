import { describe, expect, it } from "vitest";
import {
  languageChoice,
  languageName,
  recallLanguages,
  rememberLanguage,
} from "../../../app/model/languages.ts";

/** The tags of the voice that comes with the avatar which no browser names, or names like another. */
const ODD =
  "ca-ba ca-nw ca-va chr-us-qaaa-x-west cmn-latn-pinyin en-029 en-gb-scotland en-gb-x-gbclan en-gb-x-gbcwmd en-gb-x-rp " +
  "en-shaw en-us-nyc es-419 fa-latn hbs hy hy-arevela hyw mto nci piqd py qdb quc qya ru-cl ru-lv sjn smj vi-vn-x-central xex";

function store(): Pick<Storage, "getItem" | "setItem"> & { kept: Map<string, string> } {
  const kept = new Map<string, string>();
  return {
    kept,
    getItem: (key) => kept.get(key) ?? null,
    setItem: (key, value) => void kept.set(key, value),
  };
}

describe("languageChoice", () => {
  it("names the languages and sorts them", () => {
    const { others } = languageChoice(["fr", "de", "en-GB", "de", "not a tag"], [], []);
    expect(others.map(({ name }) => name)).toEqual(["British English", "French", "German", "not a tag"]);
  });

  it("has each name once, by its shortest tag", () => {
    const { others } = languageChoice(["zh-cmn", "cmn", "zh", "hy-arevmda", "hyw"], [], []);
    expect(others).toEqual([
      { tag: "zh", name: "Chinese" },
      { tag: "hyw", name: "Western Armenian" },
    ]);
  });

  it("names every language of the voice that comes with it by words, and no two alike", () => {
    const names = ODD.split(" ").map(languageName);
    for (const name of names) expect(name).toMatch(/^\p{Lu}.*\p{Ll}/u);
    expect(new Set(names).size).toBe(names.length);
    for (const name of names) expect(ODD.split(" ")).not.toContain(name);
  });

  it("says of a voice of several languages that it speaks any", () => {
    expect(languageChoice(["mul"], [], ["de"]).others).toEqual([{ tag: "mul", name: "Any language" }]);
  });

  it.each<[string, string[], string[], string[]]>([
    ["de", ["de", "en"], ["de"], ["en"]],
    ["en-GB", ["de", "en", "en-GB"], [], ["fr", "en-GB"]],
    ["en", ["de", "en"], ["fr"], ["de"]],
    ["de", ["fr", "de"], [], ["de"]],
    ["fr", ["fr"], [], []],
    ["", [], [], ["en"]],
  ])("selects %s", (expected, tags, recent, preferred) => {
    expect(languageChoice(tags, recent, preferred).selected).toBe(expected);
  });

  it("puts those that were chosen lately first, the newest before the others", () => {
    const { recent, others } = languageChoice(["de", "en", "fr", "it"], ["it", "gone", "de"], []);
    expect(recent.map(({ tag }) => tag)).toEqual(["it", "de"]);
    expect(others.map(({ tag }) => tag)).toEqual(["en", "fr"]);
  });
});

describe("languages that were chosen", () => {
  it("are remembered, the newest first, each once and four at most", () => {
    const kept = store();
    for (const tag of ["de", "en", "de", "fr", "it", "ja"]) rememberLanguage(kept, tag);
    expect(recallLanguages(kept)).toEqual(["ja", "it", "fr", "de"]);
  });

  it.each(["", "{", "7", '{"a":1}', "[1, null]"])("are none where %j was kept", (text) => {
    const kept = store();
    kept.setItem("openrois.languages", text);
    expect(recallLanguages(kept)).toEqual([]);
  });

  it("are not remembered where that is forbidden, and nothing breaks", () => {
    const forbidden = {
      getItem: (): string | null => null,
      setItem: (): void => {
        throw new Error("forbidden");
      },
    };
    rememberLanguage(forbidden, "de");
    expect(recallLanguages(forbidden)).toEqual([]);
  });
});
