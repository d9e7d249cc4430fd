import { expect, it } from "vitest";
import { deflection } from "../../../app/panels/stick.ts";

it.each([
  [
    [20, 0, 40],
    [0.5, 0],
  ],
  [
    [0, -40, 40],
    [0, -1],
  ],
  [
    [0, -400, 40],
    [0, -1],
  ],
  [
    [30, 40, 40],
    [0.6, 0.8],
  ],
  [
    [0, 0, 0],
    [0, 0],
  ],
] as const)("the knob at %j", ([dx, dy, radius], [x, y]) => {
  const at = deflection(dx, dy, radius);
  expect(at[0]).toBeCloseTo(x);
  expect(at[1]).toBeCloseTo(y);
});
