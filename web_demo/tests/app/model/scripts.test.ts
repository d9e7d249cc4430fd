import { describe, expect, it } from "vitest";
import { spellingHint } from "../../../app/model/scripts.ts";

describe("spellingHint", () => {
  it.each([
    ["Hello, world", "en"],
    ["漢字", "zh"],
    ["漢字", "cmn"],
    ["漢字", "yue"],
    ["한국", "ko"],
    ["かな カナ", "ja"],
    ["Привет", "ru"],
    ["Zdravo", "sr"],
    ["hello", "ru"],
    ["123 !?", "ja"],
    ["漢字", "not a tag"],
    ["漢字", ""],
    ["", "en"],
  ])("has nothing to say of %j in %s", (text, tag) => expect(spellingHint(text, tag, "x")).toBe(""));

  it("names the letters, the language and the remedy", () => {
    expect(spellingHint("the word 漢字", "en", "English")).toBe(
      "“漢字” may be spelled out: these are Chinese characters, and the voice speaks English. Choose another language.",
    );
    expect(spellingHint("日本語を話す", "ja", "Japanese")).toBe(
      "“日本語” may be spelled out: write it in hiragana or katakana.",
    );
    expect(spellingHint("Здравствуйте", "en", "English")).toContain("“Здравств…”");
  });
});
