import { afterEach, beforeEach, expect, it, vi } from "vitest";
import type { BodyControl, ControlState, GiveBack } from "../../../app/model/body_control.ts";
import { Handover } from "../../../app/panels/handover.ts";
import { stubPage } from "../../support/elements.ts";
import type { FakeElement } from "../../support/elements.ts";

let yes: FakeElement;
let no: FakeElement;
let words: FakeElement;
let bar: FakeElement;
let handover: Handover;
let done: string[];
const body = {
  state: { kind: "free" } as ControlState,
  nextRequest: null,
  stops: 0,
  takeOver: async (): Promise<GiveBack> => (done.push("take over"), () => done.push("give back")),
  requestControl: async (): Promise<GiveBack> => (done.push("request"), () => done.push("give back")),
  handBack: () => void done.push("hand back"),
};
const stands = (state: ControlState): string[] => {
  body.state = state;
  handover.render();
  const shown = (button: FakeElement): string => (button.hidden ? "" : button.textContent);
  return bar.hidden ? [] : [words.textContent, shown(yes), shown(no)];
};
const settle = (): Promise<void> => new Promise((resolve) => setTimeout(resolve));
/** A press of a button, which is not the second one of a double click. */
const press = (button: FakeElement): boolean =>
  button.dispatchEvent(Object.assign(new Event("click"), { detail: 1 }));
const OTHER = { kind: "other", holder: "night watch", absent: false } as const;

beforeEach(() => {
  const find = stubPage();
  done = [];
  [bar, yes, no] = [find("handover"), find("handover-yes"), find("handover-no")];
  words = document.querySelector('[data-role="handover-words"]') as unknown as FakeElement;
  const drive = (): boolean => (done.push("drive"), true);
  handover = new Handover(body as unknown as BodyControl, drive, document);
  handover.shown = true;
});

afterEach(() => {
  vi.unstubAllGlobals();
});

it("takes control over from an application that may rank lower, and asks any other for it", async () => {
  expect(stands({ ...OTHER, mayTakeOver: true })).toEqual(["night watch has control", "Take over", ""]);
  press(yes);
  await settle();
  expect(stands({ ...OTHER, mayTakeOver: false })).toEqual(["night watch has control", "Ask for it", ""]);
  press(yes);
  await settle();
  expect(done).toEqual(["take over", "drive", "request", "drive"]);
});

it("only holds what is granted after a STOP", async () => {
  let grant = (_: GiveBack): void => undefined;
  body.requestControl = () => new Promise((resolve) => (grant = resolve));
  stands({ ...OTHER, mayTakeOver: false });
  press(yes);
  body.stops += 1;
  body.state = { kind: "mine", lender: "" };
  grant(() => done.push("give back"));
  await settle();
  expect(stands(body.state)).toEqual(["You have control", "", "Give back"]);
  press(no);
  await settle();
  expect(done).toEqual(["give back"]);
});

it("hands back what was taken over, also while it drives", () => {
  expect(stands({ kind: "mine", lender: "" })).toEqual([]);
  expect(stands({ kind: "mine", lender: "night watch" })).toEqual([
    "You have control in place of night watch",
    "",
    "Hand back",
  ]);
  press(no);
  expect(done).toEqual(["hand back"]);
});
