import { describe, expect, it } from "vitest";
import { Held } from "../../sdk/input/held.ts";
import { message, readEngineMessage } from "../../sdk/input/messages.ts";

const pad = (axes: number[], ...down: number[]): { axes: number[]; buttons: { value: number }[] } => ({
  axes,
  buttons: Array.from({ length: 17 }, (_, index) => ({ value: down.includes(index) ? 1 : 0 })),
});

describe("Held", () => {
  it("holds keys until they go up, and returns each change once", () => {
    const held = new Held();
    expect(held.key("KeyW", true)).toEqual({ event: "key", code: "KeyW", down: true });
    expect(held.key("KeyW", true)).toBeNull();
    expect(held.state).toEqual({ keys: ["KeyW"] });
    expect(held.active).toBe(true);
    expect(held.key("KeyW", false)).toEqual({ event: "key", code: "KeyW", down: false });
    expect(held.key("KeyW", false)).toBeNull();
    expect(held.state).toEqual({});
    expect(held.active).toBe(false);
  });

  it.each(["", "Key W", "ß", "x".repeat(33)])("does not take %j for a key", (code) => {
    expect(new Held().key(code, true)).toBeNull();
  });

  it("never holds more than fits a message", () => {
    const held = new Held();
    for (let index = 0; index < 30; index += 1) {
      held.key(`F${index}`, true);
      held.touch(index, true, 2, -1);
    }
    held.pad(pad([NaN, 2, -2, 0.123456, 1]));
    expect(held.state.keys).toHaveLength(16);
    expect(held.state.touches).toHaveLength(10);
    expect(held.state.touches?.[0]).toEqual([0, 1, 0]);
    expect(held.state.gamepad?.axes).toEqual([0, 1, -1, 0.1235]);
    expect(new TextEncoder().encode(message(held.state)).length).toBeLessThan(1024);
  });

  it("knows where the pointer is and what is pressed", () => {
    const held = new Held();
    held.move(0.5, 0.25, 0);
    expect([held.state.pointer, held.active]).toEqual([[0.5, 0.25, 0], false]);
    expect(held.button(0, true, 0.5, 0.5, 1)).toEqual({
      event: "button",
      button: 0,
      down: true,
      x: 0.5,
      y: 0.5,
    });
    expect(held.button(7, true, 0.5, 0.5, 1)).toBeNull();
    expect(held.wheel(0, -120.04, 0.1, 0.2)).toEqual({ event: "wheel", dx: 0, dy: -120, x: 0.1, y: 0.2 });
    expect([held.state.pointer, held.active]).toEqual([[0.1, 0.2, 1], true]);
  });

  it("returns changes for fingers that come and go, not for moves", () => {
    const held = new Held();
    expect(held.touch(7, true, 0.1, 0.1)).toMatchObject({ event: "touch", id: 7, down: true });
    expect(held.touch(7, true, 0.2, 0.2)).toBeNull();
    expect(held.state.touches).toEqual([[7, 0.2, 0.2]]);
    expect(held.touch(7, false, 0.2, 0.2)).toMatchObject({ down: false });
    expect(held.touch(7, false, 0.2, 0.2)).toBeNull();
  });

  it("returns changes of gamepad buttons, and ignores a stick at rest", () => {
    const held = new Held();
    expect(held.pad(pad([0.04, -0.04, 0, 0]))).toEqual([]);
    expect(held.active).toBe(false);
    expect(held.pad(pad([0, 0, 0, 0], 0, 12))).toEqual([
      { event: "pad", button: 0, down: true },
      { event: "pad", button: 12, down: true },
    ]);
    expect(held.active).toBe(true);
    expect(held.pad(null)).toHaveLength(2);
    expect(held.state).toEqual({});
    held.pad(pad([0.2, 0, 0, 0]));
    expect(held.active).toBe(true);
  });

  it("releases everything", () => {
    const held = new Held();
    held.key("KeyW", true);
    held.move(0.5, 0.5, 1);
    held.touch(1, true, 0, 0);
    held.pad(pad([1, 0, 0, 0]));
    held.clear();
    expect([held.state, held.active]).toEqual([{}, false]);
  });
});

describe("a stick on the screen", () => {
  it("is a gamepad's left stick, and adds to that", () => {
    const held = new Held();
    held.stick(0.5, -1);
    expect(held.state).toEqual({ gamepad: { axes: [0.5, -1], buttons: [] } });
    expect(held.active).toBe(true);
    held.pad(pad([0.25, -0.5, 0.75, 0]));
    expect(held.state.gamepad?.axes).toEqual([0.75, -1, 0.75, 0]);
    held.stick(0, 0);
    expect(held.state.gamepad?.axes).toEqual([0.25, -0.5, 0.75, 0]);
  });

  it("is nothing once it is let go, or all is", () => {
    const held = new Held();
    held.stick(-1, 0);
    held.stick(0, 0);
    expect([held.state, held.active]).toEqual([{}, false]);
    held.stick(1, 1);
    held.clear();
    expect(held.state).toEqual({});
  });
});

describe("what is held while everything is halted", () => {
  it("counts again once it was let go", () => {
    const held = new Held();
    const still = { axes: [0, 0.02], buttons: [] };
    held.key("KeyW", true);
    held.stick(0, -1);
    held.pad(pad([0, -1], 1));
    held.button(0, true, 0.5, 0.5, 1);
    held.halt();
    held.halt();
    expect([held.state, held.active]).toEqual([{}, false]);
    held.stick(0.2, -1);
    held.pad(pad([0, -0.9], 1));
    held.move(0.6, 0.5, 1);
    // One that cannot be read, since the page is not used now, was not let go.
    held.pad(null);
    held.pad(pad([0, -0.9], 1));
    expect([held.state, held.active]).toEqual([{ pointer: [0.6, 0.5, 0] }, false]);
    held.stick(0, 0);
    held.pad(still);
    held.move(0.6, 0.5, 0);
    held.stick(0, -1);
    expect(held.state.gamepad).toEqual({ axes: [0, -0.98], buttons: [] });
    held.stick(0, 0);
    held.pad(pad([0, -1], 1));
    held.button(0, true, 0.6, 0.5, 1);
    expect(held.state).toMatchObject({ pointer: [0.6, 0.5, 1], gamepad: { axes: [0, -1] } });
  });
});

describe("messages", () => {
  it("have increasing numbers over all senders", () => {
    const [first, second] = [message({}), message({ event: "release", why: "bye" })].map(
      (text) => JSON.parse(text) as { seq: number; t: number; why?: string },
    );
    expect((second?.seq ?? 0) - (first?.seq ?? 0)).toBe(1);
    expect(second?.why).toBe("bye");
  });

  it.each([
    ['{"event":"stopped","reason":"why"}', { event: "stopped", reason: "why" }],
    ['{"event":"refused","reason":"why"}', { event: "refused", reason: "why" }],
    ['{"event":"paced","reason":"slower"}', { event: "paced", reason: "slower" }],
    ['{"event":"danced","reason":"why"}', null],
    ['{"event":"stopped"}', null],
    ["null", null],
    ["{", null],
  ])("of the engine: %s", (text, message) => {
    expect(readEngineMessage(text)).toEqual(message);
  });
});
