import { expect, it } from "vitest";
import { Caption } from "../../../app/model/caption_text.ts";

const LONG =
  "Once upon a time there was an avatar. It told long stories to all who came to see it. " +
  "No one ever heard one of them to its end, because all of them fell asleep before that came.";

function at(text: string, word: string): string {
  const caption = new Caption("1", text);
  caption.wordHeard(word, text.indexOf(word), word.length);
  const { before, word: marked, after } = caption.shown;
  expect(marked).toBe(word);
  return `${before}${marked}${after}`;
}

it("shows a short text whole, with the word that is heard", () => {
  const caption = new Caption("1", "Green parrots whistle.");
  expect(caption.shown).toEqual({ before: "", word: "", after: "Green parrots whistle." });
  caption.wordHeard("parrots", 6, 7);
  expect(caption.shown).toEqual({ before: "Green ", word: "parrots", after: " whistle." });
});

it("shows a long text piece by piece, by sentences, else by words", () => {
  expect(at(LONG, "Once")).toBe("Once upon a time there was an avatar. ");
  expect(at(LONG, "avatar")).toBe("Once upon a time there was an avatar. ");
  expect(at(LONG, "stories")).toBe("It told long stories to all who came to see it. ");
  expect(at(LONG, "heard")).toBe(
    "No one ever heard one of them to its end, because all of them fell asleep before ",
  );
  expect(at(LONG, "came.")).toBe("that came.");
});

it("breaks what has neither sentences nor spaces, and keeps a word whole", () => {
  expect(at("ア".repeat(200), "ア").length).toBe(84);
  expect(at(`${"x".repeat(100)} y`, "x".repeat(100))).toBe("x".repeat(100));
});

it("shows of SSML what is said", () => {
  const text = "<speak>Hello <emphasis>there</emphasis> &amp; here</speak>";
  expect(at(text.replace(/<[^>]*>/g, ""), "there")).toContain("there");
  const caption = new Caption("1", text, true);
  caption.wordHeard("there", text.indexOf("there"), 5);
  expect(caption.shown).toEqual({ before: "Hello ", word: "there", after: " & here" });
});

it("shows the last words of a text whose beginning was missed", () => {
  const caption = new Caption("1", null);
  expect(caption.shown).toEqual({ before: "", word: "", after: "" });
  for (let count = 1; count <= 10; count += 1) caption.wordHeard(`w${count}`, count, 2);
  expect(caption.shown).toEqual({ before: "w3 w4 w5 w6 w7 w8 w9 ", word: "w10", after: "" });
});

it("cuts no character in two where there is no better place", () => {
  const { before, word, after } = new Caption("1", `a${"😀".repeat(60)}`).shown;
  expect(`${before}${word}${after}`).toBe(`a${"😀".repeat(41)}`);
});
