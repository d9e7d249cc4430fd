import { afterEach, beforeEach, expect, it, vi } from "vitest";
import { ComponentWatch } from "../../../app/model/component_status.ts";
import type { Availability } from "../../../app/model/component_status.ts";
import { Client } from "../../../sdk/rois/client.ts";
import { RoISError } from "../../../sdk/rois/errors.ts";
import { FakeGateway } from "../../support/fake_gateway.ts";

let status: string;
let client: Client;
let heard: Availability[];

beforeEach(async () => {
  vi.useFakeTimers();
  status = "READY";
  heard = [];
  const gateway = new FakeGateway([]).on("rois.query.query", () => ({
    results: [{ name: "status", data_type_ref: "Component_Status", value: status }],
  }));
  client = new Client("ws://test/", { webSocket: gateway.webSocket });
  await client.connect();
});

afterEach(() => {
  vi.useRealTimers();
});

it("asks again until the component can be used", async () => {
  status = "UNINITIALIZED";
  const watch = new ComponentWatch(client, (each) => void heard.push(each));
  watch.watch("a/viewpoint");
  await vi.advanceTimersByTimeAsync(12_000);
  expect(heard).toEqual(["UNINITIALIZED", "UNINITIALIZED", "UNINITIALIZED"]);
  status = "READY";
  await vi.advanceTimersByTimeAsync(60_000);
  expect(heard.slice(3)).toEqual(["READY"]);
});

it("asks again where what the listener asked thereupon has failed", async () => {
  let failing = 2;
  const watch = new ComponentWatch(client, async (each) => {
    heard.push(each);
    await Promise.resolve();
    if (failing-- > 0) throw new Error("no answer");
  });
  watch.watch("a/viewpoint");
  await vi.advanceTimersByTimeAsync(60_000);
  expect(heard).toEqual(["READY", "READY", "READY"]);
});

it("asks no more for what is not looked at any more", async () => {
  let fail: (error: Error) => void = () => undefined;
  const watch = new ComponentWatch(client, (each) => {
    heard.push(each);
    return each === null ? undefined : new Promise<void>((_, reject) => (fail = reject));
  });
  watch.watch("a/viewpoint");
  await vi.advanceTimersByTimeAsync(100);
  watch.watch(null);
  fail(new Error("too late"));
  await vi.advanceTimersByTimeAsync(60_000);
  expect(heard).toEqual(["READY", null]);
});

it("does not ask again for what the component does not have", async () => {
  const watch = new ComponentWatch(client, (each) => {
    heard.push(each);
    return Promise.reject(new RoISError("UNSUPPORTED", "rois.query.query"));
  });
  watch.watch("a/viewpoint");
  await vi.advanceTimersByTimeAsync(60_000);
  expect(heard).toEqual(["READY"]);
});
