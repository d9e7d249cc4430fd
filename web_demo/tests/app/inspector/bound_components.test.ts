import { describe, expect, it } from "vitest";
import { BoundComponents } from "../../../app/inspector/bound_components.ts";
import type { JsonObject, Traffic } from "../../../sdk/index.ts";

let nextId = 1;

/** Lets bound see a call and its answer; returns whether the answer changed them. */
function call(bound: BoundComponents, method: string, params: JsonObject, result: JsonObject): boolean {
  const id = nextId++;
  const see = (direction: Traffic["direction"], kind: Traffic["kind"], message: JsonObject): boolean =>
    bound.observe({ direction, kind, method: `rois.command.${method}`, at: 0, message: { id, ...message } });
  expect(see("sent", "request", { params })).toBe(false);
  return see("received", "response", { result });
}

const OK = { return_code: "OK" };
const lamp = { component_ref: "a/lamp" };

describe("BoundComponents", () => {
  it("are what was bound and not released", () => {
    const bound = new BoundComponents();
    expect(call(bound, "bind", lamp, OK)).toBe(true);
    expect(call(bound, "bind", lamp, OK)).toBe(false);
    expect(bound.has("a/lamp")).toBe(true);
    expect(call(bound, "release", lamp, OK)).toBe(true);
    expect(bound.has("a/lamp")).toBe(false);
    expect(call(bound, "bind_any", { condition: "" }, { ...OK, component_ref: "a/bell" })).toBe(true);
    expect(bound.has("a/bell")).toBe(true);
  });

  it("come and go with their part, and by other applications", () => {
    const bound = new BoundComponents();
    const told = (state: string): boolean =>
      bound.observe({
        direction: "received",
        kind: "notification",
        method: "openrois.lease.changed",
        at: 0,
        message: { params: { ...lamp, state } },
      });
    call(bound, "bind", lamp, OK);
    expect([told("HELD"), bound.has("a/lamp")]).toEqual([true, false]);
    expect([told("MINE"), bound.has("a/lamp")]).toEqual([true, true]);
    expect([told("MINE"), told("FREE"), bound.has("a/lamp")]).toEqual([false, true, false]);
  });

  it("are not what was refused, or something else", () => {
    const bound = new BoundComponents();
    expect(call(bound, "bind", lamp, { return_code: "OUT_OF_RESOURCES" })).toBe(false);
    expect(call(bound, "search", lamp, OK)).toBe(false);
    const answer = { direction: "received", kind: "error", at: 0 } as const;
    expect(bound.observe({ ...answer, method: "rois.command.bind", message: { id: 900 } })).toBe(false);
    expect(bound.has("a/lamp")).toBe(false);
  });

  it("are lost with the component, or all at once", () => {
    const bound = new BoundComponents();
    call(bound, "bind", lamp, OK);
    call(bound, "bind", { component_ref: "b/lamp" }, OK);
    bound.lose((ref) => ref.startsWith("a/"));
    expect([bound.has("a/lamp"), bound.has("b/lamp")]).toEqual([false, true]);
  });

  it("drop the oldest unanswered requests", () => {
    const bound = new BoundComponents();
    const ask = (id: number): boolean =>
      bound.observe({
        direction: "sent",
        kind: "request",
        method: "rois.command.bind",
        at: 0,
        message: { id, params: lamp },
      });
    for (let id = 1000; id < 1300; id++) ask(id);
    const late = { direction: "received", kind: "response", method: "rois.command.bind", at: 0 } as const;
    bound.observe({ ...late, message: { id: 1000, result: OK } });
    expect(bound.has("a/lamp")).toBe(false);
    bound.observe({ ...late, message: { id: 1299, result: OK } });
    expect(bound.has("a/lamp")).toBe(true);
  });
});
