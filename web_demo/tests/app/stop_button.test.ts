import { afterEach, beforeEach, expect, it, vi } from "vitest";
import { StopButton } from "../../app/stop_button.ts";
import { Client } from "../../sdk/rois/client.ts";
import { stubPage } from "../support/elements.ts";
import { FakeGateway } from "../support/fake_gateway.ts";

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
  stop.setEngine("a", []);
  find("stop-all").click();
  expect(forget).toHaveBeenCalledOnce();
  await vi.advanceTimersByTimeAsync(50);
  expect(gateway.called("openrois.stop_all")).toEqual([{ engine_id: "a" }]);
  expect(find("stop-all").textContent).toBe("Not stopped");
});
