import { existsSync, readFileSync } from "node:fs";
import { describe, expect, it } from "vitest";
import {
  CELLS,
  readStamp,
  stampBits,
  stampRows,
  stampTime,
  stampWallTime,
  stripBits,
} from "../../sdk/media/stamp.ts";

/** Made by the engine's side; both sides must read them alike. */
const VECTORS = new URL("../../../tests/streaming/stamp_vectors.json", import.meta.url);

/** A strip as a video would give it: one cell is `cellWidth` pixels wide. */
function paint(bits: number[], cellWidth: number, height: number): Uint8ClampedArray {
  const width = CELLS * cellWidth;
  const pixels = new Uint8ClampedArray(4 * width * height);
  for (let y = 0; y < height; y++) {
    for (let x = 0; x < width; x++) {
      pixels.fill(bits[Math.floor(x / cellWidth)] ? 235 : 16, 4 * (y * width + x), 4 * (y * width + x) + 3);
    }
  }
  return pixels;
}

describe("readStamp", () => {
  it.each([
    { number: 0, time: 0 },
    { number: 1, time: 1 },
    { number: 2 ** 24 - 1, time: 2 ** 44 - 1 },
    { number: 123_456, time: 17_857_000_000_123 % 2 ** 44 },
  ])("reads what stampBits writes: %o", (stamp) => {
    expect(readStamp(stampBits(stamp))).toEqual(stamp);
  });

  it("follows the format to the bit", () => {
    // CRC-8/SMBUS of the nine bytes 00 00 01 00 00 00 00 00 02, right-aligned 24 + 44 bits: number 0x10, time 2.
    const bits = stampBits({ number: 16, time: 2 });
    expect(bits).toHaveLength(CELLS);
    expect(bits.slice(0, 4)).toEqual([1, 0, 1, 0]);
    expect(bits.slice(4, 28).join("")).toBe("000000000000000000010000");
    expect(bits.slice(28, 72).join("")).toBe("0".repeat(42) + "10");
    expect(Number.parseInt(bits.slice(72).join(""), 2)).toBe(crcOfBytes([0, 0, 1, 0, 0, 0, 0, 0, 2]));
  });

  it("refuses every stamp in which one bit is wrong", () => {
    const bits = stampBits({ number: 77, time: 9_876_543_210 });
    for (let index = 0; index < CELLS; index++) {
      const wrong = bits.with(index, 1 - (bits[index] ?? 0));
      expect(readStamp(wrong)).toBeNull();
    }
  });

  it("refuses pictures without a stamp", () => {
    expect(readStamp(new Array(CELLS).fill(0))).toBeNull();
    expect(readStamp(new Array(CELLS).fill(1))).toBeNull();
    expect(readStamp([])).toBeNull();
  });
});

describe("stripBits", () => {
  const stamp = { number: 4711, time: 1234 };

  it.each([
    [8, 8],
    [16, 16],
    [4, 8],
    [1, 1],
  ])("reads cells of %i x %i pixels", (cellWidth, height) => {
    const pixels = paint(stampBits(stamp), cellWidth, height);
    expect(readStamp(stripBits(pixels, CELLS * cellWidth, height))).toEqual(stamp);
  });

  it("ignores the edges of the cells, where the codec smears", () => {
    const pixels = paint(stampBits(stamp), 8, 8);
    for (let at = 0; at < pixels.length; at += 4) {
      const x = (at / 4) % 640;
      if (x % 8 < 2 || x % 8 > 5) pixels.fill(128, at, at + 3);
    }
    expect(readStamp(stripBits(pixels, 640, 8))).toEqual(stamp);
  });
});

describe("stampRows", () => {
  it.each([
    [360, 8],
    [720, 16],
    [1080, 24],
    [180, 8],
    [405, 9],
  ])("of a picture of %i rows are %i", (height, rows) => {
    expect(stampRows(height)).toBe(rows);
  });
});

describe("stampWallTime", () => {
  it.each([1_785_000_000_000.5, 1_759_218_604_441.5, 1_759_218_604_441.6])("restores %d", (wall) => {
    const carried = stampTime(wall);
    expect(carried).toBeLessThan(2 ** 44);
    expect(stampWallTime(carried, wall + 40)).toBeCloseTo(wall, 6);
    expect(stampWallTime(carried, wall - 40)).toBeCloseTo(wall, 6);
  });
});

describe.runIf(existsSync(VECTORS))("the vectors of the engine's side", () => {
  const text = existsSync(VECTORS) ? readFileSync(VECTORS, "utf8") : "[]";
  const vectors = JSON.parse(text) as { number: number; time: number; bits: string | number[] }[];

  it.each(vectors)("number $number, time $time", ({ number, time, bits }) => {
    const list = Array.from(bits, Number);
    expect(readStamp(list)).toEqual({ number, time });
    expect(stampBits({ number, time })).toEqual(list);
  });
});

/** The textbook form, byte by byte, to check the bitwise one against. */
function crcOfBytes(bytes: number[]): number {
  let crc = 0;
  for (const byte of bytes) {
    crc ^= byte;
    for (let bit = 0; bit < 8; bit++) crc = crc & 0x80 ? ((crc << 1) ^ 0x07) & 0xff : (crc << 1) & 0xff;
  }
  return crc;
}
