import { describe, expect, it } from "vitest";
import { padName } from "../../../app/panels/gamepad.ts";

describe("the name of a gamepad", () => {
  it.each([
    ["Xbox Wireless Controller (STANDARD GAMEPAD Vendor: 045e Product: 0b13)", "Xbox Wireless Controller"],
    ["045e-028e-Microsoft X-Box 360 pad", "Microsoft X-Box 360 pad"],
    ["Wireless  Controller (Vendor: 054c Product: 09cc)", "Wireless Controller"],
    ["Pad (left)", "Pad (left)"],
    ["", "Gamepad"],
    ["x".repeat(60), `${"x".repeat(31)}…`],
  ])("%s", (id, name) => expect(padName(id)).toBe(name));
});
