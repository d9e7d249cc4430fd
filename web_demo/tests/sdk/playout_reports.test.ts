import { beforeEach, expect, it, vi } from "vitest";
import { RpcError } from "../../sdk/jsonrpc/session.ts";
import { PlayoutReports } from "../../sdk/media/playout_reports.ts";
import { RoISError } from "../../sdk/rois/errors.ts";
import type { Call } from "../../sdk/rois/link.ts";

const METHOD = "rois.stream.report_playout";
const call = vi.fn<(method: string, params: object) => Promise<object>>();
let reports: PlayoutReports;

beforeEach(() => {
  call.mockReset().mockResolvedValue({ return_code: "OK" });
  reports = new PlayoutReports(call as unknown as Call);
});

const look = (delay: number | null, now: number, streamId: string | null = "avatar/1"): Promise<void> => {
  reports.observeDelay({ streamId, delay }, now);
  return Promise.resolve();
};
const sent = (): unknown[] => call.mock.calls.map(([, params]) => params);

it("reports the first delay and each greater one at once, a smaller one when it has lasted", async () => {
  await look(null, 0);
  expect(sent()).toEqual([]);
  await look(120.4, 1000);
  expect(call.mock.calls).toEqual([[METHOD, { stream_id: "avatar/1", milliseconds: 120 }]]);
  await look(180, 2000);
  for (let now = 3000; now < 5000; now += 1000) await look(150, now);
  expect(sent().slice(1)).toEqual([{ stream_id: "avatar/1", milliseconds: 180 }]);
  await look(140, 5000);
  expect(sent().slice(2)).toEqual([{ stream_id: "avatar/1", milliseconds: 150 }]);
});

it("reports nothing while little changes, or nothing plays", async () => {
  for (let now = 0; now < 10_000; now += 1000) await look(now % 2000 ? 129 : 120, now);
  await look(null, 12_000);
  await look(300, 14_000, null);
  expect(sent()).toEqual([{ stream_id: "avatar/1", milliseconds: 120 }]);
});

it("begins anew with another connection of the stream, and bounds the delay", async () => {
  await look(120, 0);
  await look(120, 100, "avatar/2");
  await look(1e9, 200, "avatar/3");
  expect(sent().slice(1)).toEqual([
    { stream_id: "avatar/2", milliseconds: 120 },
    { stream_id: "avatar/3", milliseconds: 60_000 },
  ]);
});

it.each([
  ["does not know it", new RpcError({ code: -32601, message: "Method not found" }, METHOD), 1],
  ["has no such stream", new RoISError("UNSUPPORTED", METHOD), 1],
  ["gets too many reports", new RoISError("OUT_OF_RESOURCES", METHOD), 2],
  ["was not reached", new Error("the connection is lost"), 2],
])("of an engine that %s", async (_, error, times) => {
  call.mockRejectedValueOnce(error);
  await look(120, 0);
  await new Promise((resolve) => setTimeout(resolve));
  await look(120, 2000);
  expect(sent()).toHaveLength(times);
});
