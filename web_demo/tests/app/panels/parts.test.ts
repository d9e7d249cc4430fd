import { afterEach, beforeEach, expect, it, vi } from "vitest";
import type { BodyControl } from "../../../app/model/body_control.ts";
import type { BodyPart } from "../../../app/model/part_leases.ts";
import { PartsPanel, holderWords } from "../../../app/panels/parts.ts";
import { FakeElement, stubPage } from "../../support/elements.ts";

const LEGS: BodyPart = {
  name: "legs",
  refs: ["a/teleoperation"],
  state: "free",
  holder: "",
  absent: false,
  lender: "",
  seconds: 0,
  position: 0,
};
const OTHER: BodyPart = { ...LEGS, state: "other", holder: "night watch" };

let made: FakeElement[];
let card: FakeElement;
let panel: PartsPanel;
const done: string[] = [];
const body = {
  parts: [] as BodyPart[],
  mayTakeOver: ({ state }: BodyPart) => state === "other",
  isTakenOver: ({ state }: BodyPart) => state === "mine",
  takePart: async ({ name }: BodyPart) => void done.push(`take ${name}`),
  handBackPart: async ({ name }: BodyPart) => void done.push(`hand back ${name}`),
};
/** What the first line says: its holder, and its button; empty for none. */
const line = (): string[] => {
  const [holder, button] = made;
  return [holder?.textContent ?? "", button?.hidden ? "" : (button?.textContent ?? "")];
};

beforeEach(() => {
  const find = stubPage();
  made = [];
  done.length = 0;
  body.parts = [];
  vi.spyOn(document, "createElement").mockImplementation(() => {
    const element = new FakeElement();
    made.push(element);
    return element as unknown as HTMLElement;
  });
  card = find("parts");
  panel = new PartsPanel(body as unknown as BodyControl);
});

afterEach(() => {
  vi.restoreAllMocks();
  vi.unstubAllGlobals();
});

it.each<[Partial<BodyPart>, string]>([
  [{}, "free"],
  [{ state: "mine" }, "yours"],
  [{ state: "mine", lender: "night watch", seconds: 18 }, "yours, from night watch, 18 s left"],
  [{ state: "mine", lender: "A program", seconds: 3 }, "yours, from a program, 3 s left"],
  [{ state: "other", holder: "ann", lender: "bob", seconds: 1 }, "ann, from bob, 1 s left"],
  [{ state: "other", holder: "ann", absent: true }, "ann, connection lost"],
  [{ state: "other", holder: "local" }, "Another visitor"],
])("says of %o: %s", (part, words) => {
  expect(holderWords({ ...LEGS, ...part })).toBe(words);
});

it("is not there while there is no body", () => {
  panel.render();
  expect(card.hidden).toBe(true);
  body.parts = [LEGS];
  panel.render();
  expect(card.hidden).toBe(false);
});

it("has a button for what can be done with a part, and none for those who only watch", async () => {
  body.parts = [LEGS];
  panel.render();
  expect(line()).toEqual(["free", ""]);
  body.parts = [OTHER];
  panel.render();
  expect(line()).toEqual(["night watch", "Take over"]);
  made[1]?.click();
  body.parts = [{ ...LEGS, state: "mine", lender: "night watch", seconds: 30 }];
  panel.render();
  expect(line()).toEqual(["yours, from night watch, 30 s left", "Hand back"]);
  made[1]?.click();
  expect(done).toEqual(["take legs", "hand back legs"]);
  panel.mayOperate = false;
  expect(line()[1]).toBe("");
  await Promise.resolve();
});
