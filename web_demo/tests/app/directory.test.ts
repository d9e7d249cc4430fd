import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import { BodyDirectory } from "../../app/model/bodies.ts";
import { ComponentWatch, isUsable } from "../../app/model/component_status.ts";
import type { Availability } from "../../app/model/component_status.ts";
import { Client } from "../../sdk/index.ts";
import { FakeGateway } from "../support/fake_gateway.ts";

let gateway: FakeGateway;
let client: Client;
let engines: string[];

beforeEach(() => {
  vi.useFakeTimers();
  engines = ["a", "b"];
  gateway = new FakeGateway();
  gateway.on("rois.system.get_profile", () => ({
    profile: {
      identifier: { code: "gateway" },
      sub_profiles: engines.map((id) => ({ identifier: { code: id }, component_ids: [`${id}/v`] })),
    },
    component_profiles: Object.fromEntries(
      engines.map((id) => [
        `${id}/v`,
        { identifier: { code: id === "r" ? "Navigation" : "VideoStreaming" }, name: "v" },
      ]),
    ),
  }));
  client = new Client("ws://test/", { webSocket: gateway.webSocket });
});

afterEach(() => {
  vi.useRealTimers();
});

describe("BodyDirectory", () => {
  it("prefers an engine that is there", async () => {
    const directories = ["b", "c"].map((id) => new BodyDirectory(client, () => undefined, id));
    await client.connect();
    await vi.advanceTimersByTimeAsync(0);
    expect(directories.map(({ chosen }) => chosen?.engineId)).toEqual(["b", "a"]);
  });

  it("shows one that can be seen before one that cannot, which can be chosen all the same", async () => {
    engines = ["r", "a"];
    const directory = new BodyDirectory(client, () => undefined);
    await client.connect();
    await vi.advanceTimersByTimeAsync(0);
    expect(directory.chosen?.engineId).toBe("a");
    directory.choose("r");
    expect(directory.chosen).toMatchObject({ engineId: "r", video: null, navigation: "r/v" });
    engines = ["r"];
    const another = new BodyDirectory(client, () => undefined);
    gateway.notify("rois.system.profile_changed", {});
    await vi.advanceTimersByTimeAsync(0);
    expect([another.chosen?.engineId, another.present]).toEqual(["r", true]);
  });

  it("reads the profile on connecting and on every change, and keeps the choice", async () => {
    const changed = vi.fn();
    const directory = new BodyDirectory(client, changed);
    expect([directory.bodies, directory.chosen, directory.present]).toEqual([null, null, false]);
    await client.connect();
    await vi.advanceTimersByTimeAsync(0);
    expect(directory.chosen?.engineId).toBe("a");
    directory.choose("b");
    directory.choose("unheard of");
    expect(directory.chosen?.engineId).toBe("b");
    expect(changed).toHaveBeenCalledTimes(3);

    engines = ["a"];
    gateway.notify("rois.system.profile_changed", {});
    await vi.advanceTimersByTimeAsync(0);
    expect([directory.chosen?.engineId, directory.present]).toEqual(["b", false]);

    engines = ["a", "b"];
    gateway.notify("rois.system.profile_changed", {});
    await vi.advanceTimersByTimeAsync(0);
    expect(directory.present).toBe(true);
  });

  it("reads once more, not once each, when changes come faster than profiles", async () => {
    new BodyDirectory(client, () => undefined);
    await client.connect();
    for (let count = 0; count < 5; count++) gateway.notify("rois.system.profile_changed", {});
    await vi.advanceTimersByTimeAsync(0);
    expect(gateway.called("rois.system.get_profile")).toHaveLength(2);
  });

  it("survives a profile that cannot be read", async () => {
    gateway.on("rois.system.get_profile", () => ({ return_code: "ERROR" }));
    const directory = new BodyDirectory(client, () => undefined);
    await client.connect();
    await vi.advanceTimersByTimeAsync(0);
    expect(directory.bodies).toBeNull();
  });
});

describe("ComponentWatch", () => {
  it("asks until the component can be used", async () => {
    let status = "ERROR";
    gateway.on("rois.query.query", () => ({
      results: [{ name: "status", data_type_ref: "x", value: status }],
    }));
    const seen: Availability[] = [];
    const watch = new ComponentWatch(client, (each) => void seen.push(each));
    await client.connect();
    watch.watch("a/speech");
    await vi.advanceTimersByTimeAsync(5000);
    status = "READY";
    await vi.advanceTimersByTimeAsync(60_000);
    expect(seen).toEqual(["ERROR", "ERROR", "READY"]);
    expect(gateway.called("rois.query.query")[0]).toEqual({
      query_type: "component_status",
      condition: "component_ref = 'a/speech'",
    });
    watch.watch(null);
    expect(seen.at(-1)).toBeNull();
  });

  it("forgets what it asked about before", async () => {
    const seen: Availability[] = [];
    gateway.on("rois.query.query", () => ({ return_code: "UNSUPPORTED" }));
    const watch = new ComponentWatch(client, (each) => void seen.push(each));
    watch.watch("a/speech");
    watch.watch(null);
    await vi.advanceTimersByTimeAsync(20_000);
    expect(seen).toEqual([null]);
    await client.connect();
    watch.watch("a/speech");
    await vi.advanceTimersByTimeAsync(0);
    expect(seen).toEqual([null, null]);
  });

  it.each<[Availability, boolean]>([
    ["READY", true],
    ["BUSY", true],
    ["WARNING", true],
    ["ERROR", false],
    ["UNINITIALIZED", false],
    [null, false],
  ])("%s: usable %s", (status, usable) => {
    expect(isUsable(status)).toBe(usable);
  });
});
