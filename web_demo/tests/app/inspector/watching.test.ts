import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import { FAULTS_KEPT, FaultLog } from "../../../app/inspector/fault_log.ts";
import { StatusWatch } from "../../../app/inspector/status_watch.ts";
import { Client } from "../../../sdk/index.ts";
import { FakeGateway, Refusal } from "../../support/fake_gateway.ts";

let gateway: FakeGateway;
let client: Client;

beforeEach(async () => {
  vi.useFakeTimers();
  vi.stubGlobal("document", { visibilityState: "visible" });
  gateway = new FakeGateway();
  client = new Client("ws://test/", { webSocket: gateway.webSocket });
  await client.connect();
});

afterEach(() => {
  vi.useRealTimers();
  vi.unstubAllGlobals();
});

const queries = (): unknown[] => gateway.called("rois.query.query").map(({ condition }) => condition);
const settle = (): Promise<unknown> => vi.advanceTimersByTimeAsync(0);

describe("StatusWatch", () => {
  const watched = (count: number): Map<string, string> =>
    new Map(Array.from({ length: count }, (_, number) => [`e/${number}`, "how_is_it"]));
  let seen: [string, string | null][];
  let watch: StatusWatch;

  beforeEach(() => {
    seen = [];
    watch = new StatusWatch(client, (ref, status) => seen.push([ref, status]));
    const results = [
      { name: "x", data_type_ref: "string", value: "y" },
      { name: "z", data_type_ref: "Component_Status", value: "READY" },
    ];
    gateway.on("rois.query.query", () => ({ results }));
  });

  it("asks what is new at once, what is close in every round, and the rest in every third", async () => {
    watch.watch(watched(2), "e/0");
    await settle();
    expect(seen).toEqual([
      ["e/0", "READY"],
      ["e/1", "READY"],
    ]);
    await vi.advanceTimersByTimeAsync(2000);
    await vi.advanceTimersByTimeAsync(2000);
    await vi.advanceTimersByTimeAsync(2000);
    const close = "component_ref = 'e/0'";
    const other = "component_ref = 'e/1'";
    expect(queries()).toEqual([close, other, close, close, close, other]);
  });

  it("queries no component that is not watched any more, and none while the page is hidden", async () => {
    watch.watch(watched(1), "e/0");
    await settle();
    vi.stubGlobal("document", { visibilityState: "hidden" });
    await vi.advanceTimersByTimeAsync(10_000);
    expect(queries()).toHaveLength(1);
    watch.watch(new Map(), "");
    watch.poke("e/0");
    vi.stubGlobal("document", { visibilityState: "visible" });
    await vi.advanceTimersByTimeAsync(10_000);
    expect(queries()).toHaveLength(1);
  });

  it("has few questions at a time, and asks again what has changed while it was asked", async () => {
    const answers: ((answer: object) => void)[] = [];
    gateway.on("rois.query.query", () => new Promise((resolve) => answers.push(resolve as never)));
    watch.watch(watched(9), "");
    await settle();
    expect(queries()).toHaveLength(4);
    watch.poke("e/0");
    await settle();
    expect(queries()).toHaveLength(4);
    answers[0]?.({ results: [] });
    await settle();
    expect(queries().filter((condition) => condition === "component_ref = 'e/0'")).toHaveLength(2);
    expect(seen).toEqual([["e/0", null]]);
  });

  it("knows nothing of one that refuses", async () => {
    gateway.on("rois.query.query", () => ({ return_code: "ERROR" }));
    watch.watch(watched(1), "");
    await settle();
    expect(seen).toEqual([["e/0", null]]);
  });
});

describe("FaultLog", () => {
  const notify = async (error_id: string): Promise<void> => {
    gateway.notify("rois.system.notify_error", { error_id, error_type: "USER_DEFINED_ERROR" });
    await settle();
  };

  it("asks for the details of every error, and tells whose it is", async () => {
    const results = [{ name: "of", data_type_ref: "string", value: "e/lamp" }];
    gateway.on("rois.system.get_error_detail", () => ({ results }));
    const changed = vi.fn();
    const log = new FaultLog(client, changed);
    await notify("e/1");
    expect(changed).toHaveBeenCalledTimes(2);
    expect(log.about("e")).toMatchObject([
      { errorId: "e/1", errorType: "USER_DEFINED_ERROR", detail: results },
    ]);
    expect(log.about("e/lamp")).toEqual(log.about("e"));
    expect([...log.about("f"), ...log.about("e/bell")]).toEqual([]);
  });

  it("keeps the newest, also where no details are served", async () => {
    gateway.on("rois.system.get_error_detail", () => {
      throw new Refusal(-32601, "Method not found");
    });
    const log = new FaultLog(client, () => undefined);
    for (let number = 0; number <= FAULTS_KEPT; number++) await notify(`e/${number}`);
    expect(log.about("e")).toHaveLength(FAULTS_KEPT);
    expect(log.about("e")[0]).toMatchObject({ errorId: `e/${FAULTS_KEPT}`, detail: { code: "-32601" } });
    expect(log.about("e/lamp")).toEqual([]);
  });
});
