import { beforeEach, describe, expect, it } from "vitest";
import { Client } from "../../sdk/rois/client.ts";
import type { IsStopped } from "../../sdk/rois/stops.ts";
import { FakeGateway } from "../support/fake_gateway.ts";

const ARM = "a/arm";

let gateway: FakeGateway;
let client: Client;

beforeEach(async () => {
  gateway = new FakeGateway(["openrois.lease"]).on("openrois.stop_all", () => ({ stopped: [] }));
  client = new Client("ws://test/", { webSocket: gateway.webSocket });
  await client.connect();
});

describe("unlessStopped", () => {
  const borrowed = (undone: string[]): [Promise<string>, () => void] => {
    let resolve = (): void => undefined;
    const work = client.control.unlessStopped(
      ARM,
      () => new Promise<string>((end) => (resolve = () => end("arm"))),
      (what) => void undone.push(what),
    );
    return [work, () => resolve()];
  };

  it("gives what was prepared, which is undone instead where it was stopped meanwhile", async () => {
    const undone: string[] = [];
    const [work, resolve] = borrowed(undone);
    await client.control.stopAll("b");
    resolve();
    expect([await work, undone]).toEqual(["arm", []]);
    const [stopped, goOn] = borrowed(undone);
    const stopping = client.control.stopAll("a");
    goOn();
    await expect(stopped).rejects.toMatchObject({
      status: "ABORT",
      reason: "it was stopped before it began",
    });
    await stopping;
    expect(undone).toEqual(["arm"]);
  });

  it("says why it could not be prepared, stopped or not", async () => {
    const work = client.control.unlessStopped(ARM, () => Promise.reject(new Error("no arm")));
    const stopping = client.control.stopAll();
    await expect(work).rejects.toThrow("no arm");
    await stopping;
  });
});

it("STOP is told at once, whether this client or a person presses it", async () => {
  const seen: boolean[][] = [];
  client.on("stopped", (isStopped: IsStopped) => seen.push([ARM, "ab/arm", "b/arm"].map(isStopped)));
  const stopping = client.control.stopAll("a");
  expect(seen).toEqual([[true, false, false]]);
  gateway.notify("openrois.lease.stopped", { engine_id: "a", by: "ann", reason: "" });
  await stopping;
  await client.control.stopAll();
  gateway.notify("openrois.lease.stopped", { engine_id: "b", by: "ann", reason: "" });
  gateway.notify("openrois.lease.stopped", { engine_id: "b", by: "", reason: "" });
  expect(seen.slice(1)).toEqual([
    [true, true, true],
    [false, false, true],
  ]);
});
