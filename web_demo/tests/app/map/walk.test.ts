import { beforeEach, expect, it } from "vitest";
import { Walk } from "../../../app/map/walk.ts";
import type { JsonObject } from "../../../sdk/jsonrpc/peer.ts";
import { Client } from "../../../sdk/rois/client.ts";
import { FakeGateway } from "../../support/fake_gateway.ts";

const NAVIGATION = "a/navigation";

let gateway: FakeGateway;
let client: Client;
let walk: Walk;
let subscribe: (answer: JsonObject) => void;

const settle = (): Promise<void> => new Promise((resolve) => setTimeout(resolve));
const go = (x: number, further = false): void =>
  walk.go({ text: `${x},0`, words: `${x} m ahead`, place: { x, y: 0 } }, further);

beforeEach(async () => {
  gateway = new FakeGateway(["openrois.lease"])
    .on("openrois.stop_all", () => ({ stopped: [] }))
    .on("rois.event.subscribe", () => new Promise((resolve) => (subscribe = resolve)));
  for (const name of ["bind", "release", "execute"]) gateway.on(`rois.command.${name}`, () => ({}));
  client = new Client("ws://test/", { webSocket: gateway.webSocket });
  await client.connect();
  walk = new Walk(client, () => undefined);
  walk.setComponents(NAVIGATION, null);
});

it("does not begin when the body is stopped before its events are subscribed to", async () => {
  go(1);
  go(2, true);
  await client.control.stopAll("a");
  subscribe({ subscribe_id: "s1" });
  await settle();
  expect([walk.state, walk.words, walk.targets]).toEqual(["stopped", "It was stopped before it began", []]);
  expect(gateway.called("rois.command.bind")).toEqual([]);
  go(3);
  await settle();
  expect(gateway.called("rois.command.execute")).toHaveLength(1);
});

it("goes on when another body is stopped", async () => {
  go(1);
  await client.control.stopAll("b");
  subscribe({ subscribe_id: "s1" });
  await settle();
  expect([walk.state, gateway.called("rois.command.execute").length]).toEqual(["walking", 1]);
});
