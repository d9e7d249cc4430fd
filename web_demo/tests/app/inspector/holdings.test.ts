import { describe, expect, it } from "vitest";
import { Holdings } from "../../../app/inspector/holdings.ts";
import type { JsonObject, Traffic } from "../../../sdk/index.ts";

let nextId = 1;

/** Lets holdings see a call and its answer; returns whether the answer changed them. */
function call(holdings: Holdings, method: string, params: JsonObject, result: JsonObject): boolean {
  const id = nextId++;
  const see = (direction: Traffic["direction"], kind: Traffic["kind"], message: JsonObject): boolean =>
    holdings.observe({
      direction,
      kind,
      method: `rois.command.${method}`,
      at: 0,
      message: { id, ...message },
    });
  expect(see("sent", "request", { params })).toBe(false);
  return see("received", "response", { result });
}

const OK = { return_code: "OK" };
const lamp = { component_ref: "a/lamp" };

describe("Holdings", () => {
  it("are what was bound and not released", () => {
    const holdings = new Holdings();
    expect(call(holdings, "bind", lamp, OK)).toBe(true);
    expect(call(holdings, "bind", lamp, OK)).toBe(false);
    expect(holdings.has("a/lamp")).toBe(true);
    expect(call(holdings, "release", lamp, OK)).toBe(true);
    expect(holdings.has("a/lamp")).toBe(false);
    expect(call(holdings, "bind_any", { condition: "" }, { ...OK, component_ref: "a/bell" })).toBe(true);
    expect(holdings.has("a/bell")).toBe(true);
  });

  it("are not what was refused, or something else", () => {
    const holdings = new Holdings();
    expect(call(holdings, "bind", lamp, { return_code: "OUT_OF_RESOURCES" })).toBe(false);
    expect(call(holdings, "search", lamp, OK)).toBe(false);
    const answer = { direction: "received", kind: "error", at: 0 } as const;
    expect(holdings.observe({ ...answer, method: "rois.command.bind", message: { id: 900 } })).toBe(false);
    expect(holdings.has("a/lamp")).toBe(false);
  });

  it("are lost with the component, or all at once", () => {
    const holdings = new Holdings();
    call(holdings, "bind", lamp, OK);
    call(holdings, "bind", { component_ref: "b/lamp" }, OK);
    holdings.lose((ref) => ref.startsWith("a/"));
    expect([holdings.has("a/lamp"), holdings.has("b/lamp")]).toEqual([false, true]);
  });

  it("do not remember questions that nobody answers for ever", () => {
    const holdings = new Holdings();
    const ask = (id: number): boolean =>
      holdings.observe({
        direction: "sent",
        kind: "request",
        method: "rois.command.bind",
        at: 0,
        message: { id, params: lamp },
      });
    for (let id = 1000; id < 1300; id++) ask(id);
    const late = { direction: "received", kind: "response", method: "rois.command.bind", at: 0 } as const;
    holdings.observe({ ...late, message: { id: 1000, result: OK } });
    expect(holdings.has("a/lamp")).toBe(false);
    holdings.observe({ ...late, message: { id: 1299, result: OK } });
    expect(holdings.has("a/lamp")).toBe(true);
  });
});
