import { afterEach, expect, it, vi } from "vitest";
import { DeviceControl } from "../../../app/panels/device_control.ts";
import type { LocalStream } from "../../../sdk/media/index.ts";
import { stubPage } from "../../support/elements.ts";

vi.mock("../../../sdk/media/index.ts", () => ({}));

afterEach(() => {
  vi.unstubAllGlobals();
});

it("gives back all that it was granted when it is turned on, off and on again while control is taken", async () => {
  const find = stubPage();
  let uses = 0;
  let grant = (): void => undefined;
  const granted = new Promise<void>((resolve) => (grant = resolve));
  const take = async (): Promise<() => void> => {
    await granted;
    uses += 1;
    return () => void (uses -= 1);
  };
  const stream = {
    captured: null as object | null,
    desire: "disconnected",
    status: null,
    captureProblem: null,
    problem: null,
    on: () => () => undefined,
    devices: async () => [],
    connect: async () => void Object.assign(stream, { captured: {}, desire: "connected" }),
    disconnect: async () => void Object.assign(stream, { captured: null, desire: "disconnected" }),
  };
  const body = find("body") as unknown as HTMLElement;
  const microphone = new DeviceControl("audio", body, take, () => undefined);
  microphone.watch(stream as unknown as LocalStream);
  const presses = [microphone.toggle(), microphone.toggle(), microphone.toggle()];
  grant();
  await Promise.all(presses);
  expect([stream.desire, uses]).toEqual(["connected", 1]);
  await microphone.toggle();
  expect([stream.desire, uses]).toEqual(["disconnected", 0]);
});
