import { describe, expect, it } from "vitest";
import { SpokenText } from "../../../app/model/spoken_text.ts";

describe("SpokenText", () => {
  it("is all ahead before its first word", () => {
    expect(new SpokenText("Hello you").parts).toEqual({ before: "", word: "", after: "Hello you" });
  });

  it("shows the word that is heard, by code points", () => {
    const text = new SpokenText("👋🏽 Hello you");
    expect(text.wordHeard("1", 3, 5)).toBe(true);
    expect(text.parts).toEqual({ before: "👋🏽 ", word: "Hello", after: " you" });
    expect(text.wordHeard("1", 9, 3)).toBe(true);
    expect(text.parts).toEqual({ before: "👋🏽 Hello ", word: "you", after: "" });
    expect(text.id).toBe("1");
  });

  it("is not moved by words of other texts, or beyond its end", () => {
    const text = new SpokenText("Hello you", "old");
    expect(text.wordHeard("old", 0, 5)).toBe(false);
    expect(text.id).toBe("");
    expect(text.wordHeard("new", 0, 5)).toBe(true);
    expect(text.wordHeard("newer", 6, 3)).toBe(false);
    expect(text.wordHeard("new", 6, 30)).toBe(false);
    expect(text.wordHeard("new", -1, 3)).toBe(false);
    expect(text.parts.word).toBe("Hello");
  });

  it("shows SSML without its tags", () => {
    const source = '<speak>Tom &amp; <emphasis level="strong">Jerry</emphasis></speak>';
    const text = new SpokenText(source, "", true);
    expect(text.parts).toEqual({ before: "", word: "", after: "Tom & Jerry" });
    expect(text.wordHeard("1", source.indexOf("Jerry"), 5)).toBe(true);
    expect(text.parts).toEqual({ before: "Tom & ", word: "Jerry", after: "" });
  });
});
