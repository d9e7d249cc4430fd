import { expect, it } from "vitest";
import { sentToWords, textsSentToWords, wordsSentToWords } from "../../../app/model/sent_to.ts";

it("says where the sound goes", () => {
  const words = sentToWords({ sent_to: "https://ears.example", allowed: true }, true);
  expect(words).toBe("To be written down, what you say is sent to https://ears.example.");
});

it("says that nothing is sent without consent", () => {
  for (const [allowed, agrees] of [
    [false, true],
    [true, false],
    [false, false],
  ] as const) {
    const words = sentToWords({ sent_to: "https://ears.example", allowed }, agrees);
    expect(words).toContain("Nothing is written down");
    expect(words).toContain("https://ears.example");
  }
});

it("says nothing where the sound stays, or where a body does not tell", () => {
  expect(sentToWords({ sent_to: "", allowed: true }, false)).toBe("");
  expect(sentToWords(null, true)).toBe("");
});

it("says where texts go", () => {
  expect(textsSentToWords("https://voice.example")).toBe(
    "To be spoken, texts are sent to https://voice.example.",
  );
  expect(textsSentToWords("")).toBe("");
});

it("says where words go to be answered, and that they do not without consent", () => {
  expect(wordsSentToWords("https://model.example", true)).toBe(
    "To be answered, what you say is sent to https://model.example.",
  );
  expect(wordsSentToWords("https://model.example", false)).toContain("you have not agreed");
  expect(wordsSentToWords("", false)).toBe("");
});
