import { expect, it } from "vitest";
import { DialogueLines, MOST_LINES, visitorName } from "../../../app/model/dialogue.ts";

const began = (speech_id: string, text: string, is_ssml = false) => ({ speech_id, text, is_ssml });

it("has what was heard and said, with the one that said it", () => {
  const lines = new DialogueLines();
  lines.heard("who are you", "You");
  lines.heard("  ", "You");
  lines.began(began("s1", "I am a robot."), "robot");
  lines.ended({ speech_id: "s1", status: "OK" });
  expect(lines.all).toEqual([
    { kind: "heard", by: "You", text: "who are you", cut: null },
    { kind: "said", by: "robot", text: "I am a robot.", cut: null },
  ]);
});

it.each([
  ["I am 🤖 a robot.", false, { word: "🤖", position: 5 }, "I am 🤖"],
  ["<speak>I <emphasis>am</emphasis> it</speak>", true, { word: "am", position: 19 }, "I am"],
  ["I am a robot.", false, {}, ""],
  ["I am", false, { word: "robot", position: 7 }, ""],
])("marks what was interrupted with what was heard: %s", (text, ssml, last, cut) => {
  const lines = new DialogueLines();
  lines.began(began("s1", text, ssml), "robot");
  lines.ended({ speech_id: "another", status: "ABORT" });
  expect(lines.all[0]?.cut).toBe(null);
  lines.ended({ speech_id: "s1", status: "ABORT", ...last });
  expect(lines.all[0]?.cut).toBe(cut);
});

it("is bounded, in lines and in characters", () => {
  const lines = new DialogueLines();
  for (let number = 0; number <= MOST_LINES; number += 1) lines.heard(`${number}`, "You");
  lines.heard("🤖".repeat(100_000), "You");
  expect(lines.all.length).toBe(MOST_LINES);
  expect(lines.all[0]?.text).toBe("2");
  expect([...(lines.all.at(-1)?.text ?? "")].length).toBe(500);
});

it("names visitors", () => {
  expect(
    ["avatar/visitor/0a1b2c3d", "avatar/visitor/own", "", undefined].map((ref) =>
      visitorName(ref, "avatar/visitor/own"),
    ),
  ).toEqual(["Visitor 0a1b2c", "You", "A visitor", "A visitor"]);
});
