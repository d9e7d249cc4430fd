import { afterEach, beforeEach, expect, it, vi } from "vitest";
import { StoppedBodies } from "../../../app/model/stopped_bodies.ts";
import { StoppedNote } from "../../../app/panels/stopped_note.ts";
import { Client } from "../../../sdk/rois/client.ts";
import { stubPage } from "../../support/elements.ts";
import type { FakeElement } from "../../support/elements.ts";
import { FakeGateway } from "../../support/fake_gateway.ts";

const BODY = { engineId: "robot", acting: ["robot/arm", "robot/leg"] };

let gateway: FakeGateway;
let bodies: StoppedBodies;
let note: StoppedNote;
let find: (testId: string) => FakeElement;
/** By whom the gateway says that the robot is stopped. */
let by: string;

const words = (): string => document.querySelector('[data-role="stopped-words"]')?.textContent ?? "";

beforeEach(async () => {
  vi.useFakeTimers();
  find = stubPage();
  by = "";
  gateway = new FakeGateway(["openrois.lease"])
    .on("openrois.lease.query", ({ component_ref = "" }) => ({ lease: { component_ref, stopped_by: by } }))
    .on("openrois.lease.release_stop", () => ({}));
  const client = new Client("ws://test/", { webSocket: gateway.webSocket });
  await client.connect();
  bodies = new StoppedBodies(client, () => note.render());
  note = new StoppedNote(bodies);
  note.watching = false;
});

afterEach(() => {
  vi.useRealTimers();
  vi.unstubAllGlobals();
});

async function settle(): Promise<void> {
  await vi.advanceTimersByTimeAsync(50);
}

function tell(engineId: string, person: string): void {
  gateway.notify("openrois.lease.stopped", { engine_id: engineId, by: person, reason: "" });
}

it("names who has stopped a body, and hands it back", async () => {
  bodies.setBodies([BODY]);
  await settle();
  expect(find("stopped").hidden).toBe(true);
  expect(gateway.called("openrois.lease.query")).toEqual([{ component_ref: "robot/arm" }]);
  tell("robot", "ann");
  await settle();
  expect(find("stopped").hidden).toBe(false);
  expect(words()).toBe("ann has stopped robot. Programs wait.");
  find("stopped-hand-back").click();
  await settle();
  expect(gateway.called("openrois.lease.release_stop")).toEqual([{ engine_id: "robot" }]);
  expect(find("stopped").hidden).toBe(true);
});

it("knows it on a page that comes later, and after a lost connection", async () => {
  by = "ann";
  bodies.setBodies([BODY]);
  await settle();
  expect(words()).toBe("ann has stopped robot. Programs wait.");
  by = "";
  gateway.socket.endSocket(1006);
  await vi.advanceTimersByTimeAsync(2000);
  bodies.setBodies([BODY]);
  await settle();
  expect(gateway.called("openrois.lease.query")).toHaveLength(2);
  expect(find("stopped").hidden).toBe(true);
});

it("asks once for each body, and forgets what is not shown any more", async () => {
  for (let times = 0; times < 3; times++) bodies.setBodies([BODY, { engineId: "lamp", acting: [] }]);
  await settle();
  expect(gateway.called("openrois.lease.query")).toHaveLength(1);
  tell("rover", "ann");
  await settle();
  expect(find("stopped").hidden).toBe(true);
  tell("robot", "ann");
  await settle();
  bodies.setBodies([]);
  expect(find("stopped").hidden).toBe(true);
});

it("says why a page that is no person's hands nothing back", async () => {
  const why = "only a person hands back to programs what a person has stopped";
  gateway.on("openrois.lease.release_stop", (_, id) => {
    gateway.notify("openrois.reason", { request_id: id, reason: why });
    return { return_code: "UNSUPPORTED" };
  });
  bodies.setBodies([BODY]);
  await settle();
  tell("robot", "ann");
  find("stopped-hand-back").click();
  await settle();
  expect(find("stopped").hidden).toBe(false);
  expect(words()).toBe(
    "ann has stopped robot. Programs wait. Only a person hands back to programs what a person has stopped.",
  );
});

it("has no button for a visitor who only watches", async () => {
  note.watching = true;
  bodies.setBodies([BODY]);
  tell("robot", "ann");
  await settle();
  expect(find("stopped").hidden).toBe(false);
  expect(find("stopped-hand-back").hidden).toBe(true);
});
