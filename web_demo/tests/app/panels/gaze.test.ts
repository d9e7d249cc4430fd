import { afterEach, beforeEach, expect, it, vi } from "vitest";
import { Gaze } from "../../../app/panels/gaze.ts";
import { Client } from "../../../sdk/rois/client.ts";
import { stubPage } from "../../support/elements.ts";
import type { FakeElement } from "../../support/elements.ts";
import { FakeGateway } from "../../support/fake_gateway.ts";
import { happen } from "../../support/fake_page.ts";

let gateway: FakeGateway;
let client: Client;
let stage: FakeElement;

/** A key goes down, or is held on; glances are that far apart. */
const press = async (repeat = false): Promise<number> => {
  happen(stage, "keydown", { key: "ArrowLeft", repeat });
  await vi.advanceTimersByTimeAsync(500);
  return gateway.called("rois.command.execute").length;
};

beforeEach(async () => {
  vi.useFakeTimers();
  stage = stubPage()("stage");
  gateway = new FakeGateway(["openrois.lease"]).on("openrois.stop_all", () => ({ stopped: [] }));
  for (const name of ["bind", "release", "execute"]) gateway.on(`rois.command.${name}`, () => ({}));
  client = new Client("ws://test/", { webSocket: gateway.webSocket });
  await client.connect();
  await vi.advanceTimersByTimeAsync(1000);
  new Gaze(client, stage as unknown as HTMLElement).setComponent("a/gaze");
});

afterEach(() => {
  vi.useRealTimers();
  vi.unstubAllGlobals();
});

it("an arrow key that is held down while a person presses STOP has to be pressed anew", async () => {
  expect([await press(), await press(true)]).toEqual([1, 2]);
  gateway.notify("openrois.lease.stopped", { engine_id: "a", by: "ann", reason: "programs wait" });
  expect([await press(true), await press(true)]).toEqual([2, 2]);
  expect([await press(), await press(true)]).toEqual([3, 4]);
  await client.control.stopAll("b");
  expect(await press(true)).toBe(5);
});
