/**
 * The stamp in the picture: which frame this is and when it was taken.
 *
 * The bottom `max(8, floor(8 H / 360))` rows are 80 cells of equal width, black for 0 and white for 1: the sync bits
 * 1010, the frame number (24 bits), the wall time in units of 0.1 ms modulo 2^44 (44 bits), and a CRC-8 (polynomial
 * 0x07, initial value 0, nothing reflected or inverted) over number and time, which stand right-aligned in 9 bytes.
 * All numbers have their highest bit first.
 */

export const CELLS = 80;
const SYNC = [1, 0, 1, 0];
const NUMBER_BITS = 24;
const TIME_BITS = 44;
const PAYLOAD_END = SYNC.length + NUMBER_BITS + TIME_BITS;
const TICKS_PER_MS = 10;
const TIME_RANGE = 2 ** TIME_BITS;

export interface Stamp {
  readonly number: number;
  /** Wall time in units of 0.1 ms, modulo 2^44. */
  readonly time: number;
}

/** Returns how many rows at the bottom of a picture of this height belong to the stamp. */
export function stampRows(height: number): number {
  return Math.max(8, Math.floor((height * 8) / 360));
}

/** Reads 80 bits; null when they are no stamp. */
export function readStamp(bits: readonly number[]): Stamp | null {
  if (bits.length !== CELLS || SYNC.some((bit, index) => bits[index] !== bit)) return null;
  // Four zero bits in front would fill the ninth byte; with the initial value 0 they change nothing.
  if (crc8(bits.slice(SYNC.length, PAYLOAD_END)) !== toNumber(bits.slice(PAYLOAD_END))) return null;
  return {
    number: toNumber(bits.slice(SYNC.length, SYNC.length + NUMBER_BITS)),
    time: toNumber(bits.slice(SYNC.length + NUMBER_BITS, PAYLOAD_END)),
  };
}

/** Returns the 80 bits of a stamp: what `readStamp` reads. */
export function stampBits(stamp: Stamp): number[] {
  const payload = [...toBits(stamp.number, NUMBER_BITS), ...toBits(stamp.time, TIME_BITS)];
  return [...SYNC, ...payload, ...toBits(crc8(payload), 8)];
}

/**
 * Returns the bits in a strip of pixels, RGBA, that was cut out of a picture and may have been scaled.
 *
 * Only the middle half of each cell counts, in both directions: the edges belong to the codec.
 */
export function stripBits(pixels: Uint8ClampedArray, width: number, height: number): number[] {
  const bits: number[] = [];
  const top = Math.floor(height / 4);
  const bottom = Math.max(top + 1, Math.ceil((height * 3) / 4));
  for (let cell = 0; cell < CELLS; cell++) {
    const start = (cell * width) / CELLS;
    const quarter = width / CELLS / 4;
    const left = Math.floor(start + quarter);
    const right = Math.max(left + 1, Math.floor(start + 3 * quarter));
    bits.push(meanLuma(pixels, width, left, right, top, bottom) >= 128 ? 1 : 0);
  }
  return bits;
}

/** Returns the milliseconds since the epoch for a stamp's time, which is the one nearest to `near`. */
export function stampWallTime(time: number, near: number): number {
  const wraps = Math.round((near * TICKS_PER_MS - time) / TIME_RANGE);
  return (time + wraps * TIME_RANGE) / TICKS_PER_MS;
}

/** Returns the time that a stamp carries for `wall`, in milliseconds since the epoch. */
export function stampTime(wall: number): number {
  return Math.round(wall * TICKS_PER_MS) % TIME_RANGE;
}

function meanLuma(
  pixels: Uint8ClampedArray,
  width: number,
  left: number,
  right: number,
  top: number,
  bottom: number,
): number {
  let sum = 0;
  for (let y = top; y < bottom; y++) {
    for (let x = left; x < right; x++) {
      const at = 4 * (y * width + x);
      sum += 0.299 * (pixels[at] ?? 0) + 0.587 * (pixels[at + 1] ?? 0) + 0.114 * (pixels[at + 2] ?? 0);
    }
  }
  return sum / ((right - left) * (bottom - top));
}

function crc8(bits: readonly number[]): number {
  let crc = 0;
  for (const bit of bits) {
    const carry = (crc >> 7) ^ bit;
    crc = ((crc << 1) & 0xff) ^ (carry ? 0x07 : 0);
  }
  return crc;
}

// The times have 44 bits: too many for the bit operators of JavaScript, few enough for its numbers.
const toNumber = (bits: readonly number[]): number => bits.reduce((value, bit) => value * 2 + bit, 0);

const toBits = (value: number, count: number): number[] =>
  Array.from({ length: count }, (_, index) => Math.floor(value / 2 ** (count - 1 - index)) % 2);
