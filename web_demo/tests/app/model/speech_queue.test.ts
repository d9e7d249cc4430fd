import { describe, expect, it } from "vitest";
import { LONGEST, MOST, QueueRefusal, SpeechQueue, isSsml, split } from "../../../app/model/speech_queue.ts";

describe("SpeechQueue", () => {
  it("gives what was added, in turn", () => {
    const queue = new SpeechQueue();
    queue.add("One.", "en");
    queue.add("Zwei.", "de");
    expect(queue.waiting.map(({ text }) => text)).toEqual(["One.", "Zwei."]);
    expect(queue.next()).toMatchObject({ text: "One.", ssml: false, language: "en" });
    expect(queue.next()).toMatchObject({ text: "Zwei.", language: "de" });
    expect(queue.next()).toBeNull();
  });

  it("gives once more what was put back", () => {
    const queue = new SpeechQueue();
    for (const text of ["One.", "Two."]) queue.add(text, "");
    const one = queue.next();
    if (one) queue.putBack(one);
    expect(queue.waiting.map(({ text }) => text)).toEqual(["One.", "Two."]);
  });

  it("forgets what is removed", () => {
    const queue = new SpeechQueue();
    for (const text of ["One.", "Two.", "Three."]) queue.add(text, "");
    queue.remove(queue.waiting[1]?.id ?? 0);
    expect(queue.waiting.map(({ text }) => text)).toEqual(["One.", "Three."]);
    queue.clear();
    expect(queue.waiting).toEqual([]);
  });

  it("loses nothing of a long text", () => {
    const text = Array.from({ length: 500 }, (_, number) => `Sentence ${number}.`).join(" ");
    const queue = new SpeechQueue();
    queue.add(text, "");
    expect(queue.waiting.length).toBe(Math.ceil(text.length / LONGEST));
    expect(queue.waiting.every((each) => [...each.text].length <= LONGEST && each.text.endsWith("."))).toBe(
      true,
    );
    expect(queue.waiting.map((each) => each.text).join(" ")).toBe(text);
  });

  it.each([
    ["SSML that is too long", `<speak>${"a".repeat(LONGEST)}</speak>`, /4,015 characters.*shorten/],
    ["more than can wait", "a".repeat((MOST + 1) * LONGEST), /44,000 characters.*shorten/],
  ])("refuses %s, and adds nothing of it", (_, text, words) => {
    const queue = new SpeechQueue();
    expect(() => queue.add(text, "")).toThrow(words);
    expect(queue.waiting).toEqual([]);
  });

  it("is bounded", () => {
    const queue = new SpeechQueue();
    for (let count = 0; count < MOST; count += 1) queue.add("Again.", "");
    expect(() => queue.add("Again.", "")).toThrow(QueueRefusal);
    expect(queue.waiting.length).toBe(MOST);
  });
});

describe("split", () => {
  it.each([
    ["Hello you.", ["Hello you."]],
    ["One. Two. Three.", ["One. Two.", "Three."]],
    ["one two three four", ["one two", "three four"]],
    ["abcdefghijklmno", ["abcdefghij", "klmno"]],
    ["👋👋👋👋👋👋👋👋👋👋👋👋", ["👋👋👋👋👋👋👋👋👋👋", "👋👋"]],
    ["   ", []],
  ])("%j", (text, parts) => expect(split(text, 10)).toEqual(parts));
});

describe("SSML", () => {
  it.each([
    ["<speak>Hello</speak>", true],
    ['  <speak version="1.1">Hello</speak>', true],
    ['<?xml version="1.0"?>\n<speak>Hello</speak>', true],
    ["<speaker>", false],
    ["Say <speak>", false],
    ["a < b", false],
  ])("is told from text: %j", (text, ssml) => expect(isSsml(text)).toBe(ssml));
});
