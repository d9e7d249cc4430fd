import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import { StopButton } from "../../../app/panels/stop_button.ts";
import { Client } from "../../../sdk/rois/client.ts";
import { stubPage } from "../../support/elements.ts";
import { FakeGateway } from "../../support/fake_gateway.ts";

beforeEach(() => {
  vi.useFakeTimers();
});

afterEach(() => {
  vi.useRealTimers();
  vi.unstubAllGlobals();
});

it("has what waits on the page forgotten at once, whatever the gateway answers", async () => {
  const find = stubPage();
  const gateway = new FakeGateway(["openrois.lease"]).on("openrois.stop_all", () => ({
    return_code: "ERROR",
  }));
  const client = new Client("ws://test/", { webSocket: gateway.webSocket });
  await client.connect();
  const forget = vi.fn();
  const stop = new StopButton(client, forget);
  stop.setBodies([{ engineId: "a", acting: [] }]);
  find("stop-all").click();
  expect(forget).toHaveBeenCalledOnce();
  await vi.advanceTimersByTimeAsync(50);
  expect(gateway.called("openrois.stop_all")).toEqual([{ engine_id: "a" }]);
  expect(find("stop-all").textContent).toBe("Not stopped");
});

it("stops every body, though one cannot be stopped, and says so", async () => {
  const find = stubPage();
  const gateway = new FakeGateway(["openrois.lease"]).on("openrois.stop_all", ({ engine_id }) => ({
    return_code: engine_id === "a" ? "ERROR" : "OK",
  }));
  const client = new Client("ws://test/", { webSocket: gateway.webSocket });
  await client.connect();
  const stop = new StopButton(client, () => undefined);
  stop.setBodies(["a", "b"].map((engineId) => ({ engineId, acting: [] })));
  find("stop-all").click();
  await vi.advanceTimersByTimeAsync(50);
  expect(gateway.called("openrois.stop_all")).toEqual([{ engine_id: "a" }, { engine_id: "b" }]);
  expect(find("stop-all").textContent).toBe("Not stopped");
});

describe("its key", () => {
  const NO_LETTERS = [
    ["a button", "button"],
    ["a list to choose from", "select"],
    ["a slider", "input[type=range]"],
    ["a checkbox", "input[type=checkbox]"],
  ] as const;
  const LETTERS = [
    ["a line of text", "input"],
    ["a search field", "input[type=search]"],
    ["a text area", "textarea"],
  ] as const;

  async function press(kind: string, key: string): Promise<unknown[]> {
    stubPage();
    const gateway = new FakeGateway(["openrois.lease"]).on("openrois.stop_all", () => ({}));
    const client = new Client("ws://test/", { webSocket: gateway.webSocket });
    await client.connect();
    new StopButton(client, () => undefined).setBodies([{ engineId: "a", acting: [] }]);
    const event = Object.assign(new Event("keydown", { cancelable: true }), { key });
    Object.defineProperty(event, "target", { value: document.querySelector(kind) });
    document.dispatchEvent(event);
    await vi.advanceTimersByTimeAsync(50);
    return gateway.called("openrois.stop_all");
  }

  it.each(NO_LETTERS)("stops everything while %s has the focus", async (_, kind) => {
    expect(await press(kind, "x")).toEqual([{ engine_id: "a" }]);
  });

  it("stops everything with Caps Lock on, too", async () => {
    expect(await press("select", "X")).toEqual([{ engine_id: "a" }]);
  });

  it.each(LETTERS)("is a letter in %s", async (_, kind) => {
    expect(await press(kind, "x")).toEqual([]);
  });
});
