import { describe, expect, it } from "vitest";
import { addressOf, idOf } from "../../../app/inspector/routes.ts";

describe("addresses", () => {
  it.each([
    ["", "#inspector"],
    ["robot", "#inspector/robot"],
    ["robot/nav", "#inspector/robot/nav"],
    ["a robot/50 % #1", "#inspector/a%20robot/50%20%25%20%231"],
  ])("of %j is %s, and leads back", (id, address) => {
    expect(addressOf(id)).toBe(address);
    expect(idOf(address)).toBe(id);
  });

  it.each([
    ["", null],
    ["#avatar", null],
    ["#inspectors", null],
    ["#inspector/%", ""],
  ])("%j leads to %j", (address, id) => {
    expect(idOf(address)).toBe(id);
  });
});
