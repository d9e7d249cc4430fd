import { afterEach, beforeEach, expect, it, vi } from "vitest";
import type { BodyControl } from "../../../app/model/body_control.ts";
import { Control } from "../../../app/panels/control.ts";
import type { InputMedia } from "../../../sdk/media/index.ts";
import type { Client } from "../../../sdk/rois/client.ts";
import { stubPage } from "../../support/elements.ts";
import type { FakeElement } from "../../support/elements.ts";

const { commands, tell } = vi.hoisted(() => ({
  commands: [] as string[],
  tell: new Map<string, (reason: string) => void>(),
}));

vi.mock("../../../sdk/media/index.ts", () => ({
  Teleoperation: class {
    operating = false;
    readonly componentRef = "a/teleoperation";
    on = (name: string, listener: (reason: string) => void): void => void tell.set(name, listener);
    attach = () => () => undefined;
    start = async (): Promise<void> => {
      commands.push("start");
      await Promise.resolve();
      this.operating = true;
    };
    stop = async (): Promise<void> => {
      commands.push("stop");
      this.operating = false;
    };
  },
}));

let uses: number;
let control: Control;
let button: FakeElement;
let words: FakeElement;
const settle = (): Promise<unknown> => vi.advanceTimersByTimeAsync(50);

beforeEach(() => {
  vi.useFakeTimers();
  const find = stubPage();
  commands.length = uses = 0;
  const take = async (): Promise<() => void> => {
    await Promise.resolve();
    uses += 1;
    return () => void (uses -= 1);
  };
  const body = { state: { kind: "mine" }, holderOf: () => "", takeControl: take } as unknown as BodyControl;
  control = new Control(
    {} as Client,
    {} as InputMedia,
    body,
    find("video") as unknown as HTMLElement,
    document,
  );
  control.setComponent("a/teleoperation");
  button = find("control-toggle");
  words = find("control-words");
});

afterEach(() => {
  vi.useRealTimers();
  vi.unstubAllGlobals();
});

it("holds the body once, however often the button is pressed before it is held", async () => {
  button.click();
  button.click();
  await settle();
  expect([commands, uses]).toEqual([["start"], 1]);
  button.click();
  await settle();
  expect([commands, uses]).toEqual([["start", "stop"], 0]);
});

it("gives back what is granted while it drives already", async () => {
  button.click();
  expect(control.drive(() => void (uses -= 1))).toBe(true);
  uses += 1;
  await settle();
  button.click();
  await settle();
  expect(uses).toBe(0);
});

it("says why control has ended, and not that what was still on its way is refused", async () => {
  button.click();
  await settle();
  tell.get("refused")?.("the way is blocked");
  expect(words.textContent).toBe("The way is blocked");
  tell.get("ended")?.("ABORT");
  control.controlLost("You have handed over control to ben.");
  tell.get("refused")?.("Teleoperation has to be bound and started first");
  expect(words.textContent).toBe("You have handed over control to ben.");
});
