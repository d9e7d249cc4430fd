import { describe, expect, it } from "vitest";
import {
  completedWords,
  limitWords,
  refusal,
  statusWords,
  tookWords,
} from "../../../app/inspector/sentences.ts";
import type { Attempt } from "../../../app/inspector/sentences.ts";
import { ConnectionLost, InvalidMessage, RequestTimeout, RoISError, RpcError } from "../../../sdk/index.ts";
import type { CompletedStatus, ComponentStatus, ReturnCode } from "../../../sdk/index.ts";

describe("refusal", () => {
  it.each<[Attempt, ReturnCode, string]>([
    ["bind", "OUT_OF_RESOURCES", "Another application"],
    ["bind", "UNSUPPORTED", "not there"],
    ["execute", "OUT_OF_RESOURCES", "bind it first"],
    ["set_parameter", "BAD_PARAMETER", "these values"],
    ["subscribe", "OUT_OF_RESOURCES", "no room"],
    ["query", "ERROR", "not able to answer"],
    ["detail", "BAD_PARAMETER", "expired"],
    ["query", "TIMEOUT", "in time"],
    ["query", "SOMETHING_NEW" as ReturnCode, "refused"],
  ])("of %s with %s says what it means", (attempt, code, words) => {
    const { code: shown, sentence } = refusal(attempt, new RoISError(code, "m"));
    expect(shown).toBe(code);
    expect(sentence).toContain(words);
  });

  it.each<[Attempt, ReturnCode, string]>([
    ["bind", "OUT_OF_RESOURCES", "Another application has bound this component: a/b is theirs"],
    ["query", "ERROR", "The component is not able to answer now: a/b is theirs"],
    ["search" as Attempt, "ERROR", "The component could not do it: a/b is theirs"],
    ["query", "SOMETHING_NEW" as ReturnCode, "The engine refused it: a/b is theirs"],
  ])("of %s with %s and a reason says why", (attempt, code, sentence) => {
    expect(refusal(attempt, new RoISError(code, "m", "", "a/b is theirs"))).toEqual({ code, sentence });
  });

  it.each([
    [new RpcError({ code: -32601, message: "no" }, "rois.x.y"), "-32601", "does not serve rois.x.y"],
    [
      new RpcError({ code: -32602, message: "no", data: [{ path: "a.b", message: "too long" }] }, "m"),
      "-32602",
      "a.b: too long",
    ],
    [new RpcError({ code: -32602, message: "no" }, "m"), "-32602", "invalid params"],
    [new RpcError({ code: -32602, message: "no", data: ["odd"] }, "m"), "-32602", "odd"],
    [new RpcError({ code: -32603, message: "broken" }, "m"), "-32603", "its log says why"],
    [new ConnectionLost("m"), "connection lost", "ended"],
    [new RequestTimeout("m"), "no answer", "in time"],
    [new InvalidMessage("rois.x.y: odd"), "error", "The gateway's answer cannot be read. Run"],
    [new Error("odd"), "error", "odd"],
    ["odd", "error", "odd"],
  ])("of %s", (error, code, words) => {
    expect(refusal("query", error).code).toBe(code);
    expect(refusal("query", error).sentence).toContain(words);
  });
});

describe("words", () => {
  it("has some for every way in which a command ends, and every status", () => {
    const ends: CompletedStatus[] = ["OK", "ERROR", "ABORT", "OUT_OF_RESOURCES", "TIMEOUT"];
    expect(new Set(ends.map((status) => completedWords(status))).size).toBe(5);
    expect(completedWords("ERROR", "set target_positions first")).toBe(
      "It was refused or went wrong: set target_positions first",
    );
    expect(completedWords("NEW" as CompletedStatus)).toContain("NEW");
    const all: (ComponentStatus | null)[] = ["UNINITIALIZED", "READY", "BUSY", "WARNING", "ERROR", null];
    expect(new Set(all.map(statusWords)).size).toBe(6);
    expect(statusWords("NEW" as ComponentStatus)).toBe("NEW");
  });

  it.each([
    [1.234, "1.2 ms"],
    [12.3, "12 ms"],
    [1234, "1.23 s"],
    [61_000, "61.0 s"],
  ])("of a time", (ms, words) => {
    expect(tookWords(ms)).toBe(words);
  });

  it("of a time limit", () => {
    expect([limitWords(500), limitWords(60_000), limitWords(2500)]).toEqual(["500 ms", "60 s", "2.5 s"]);
  });
});
