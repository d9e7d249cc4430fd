/** What a browser calls a gamepad, as people do. Pure. */

const LONGEST = 32;

/** Leaves out vendor and product numbers, and what is said of the mapping. */
export function padName(id: string): string {
  const plain = id
    .replace(/\([^()]*\b(vendor|product|standard gamepad)\b[^()]*\)?/gi, "")
    .replace(/^[0-9a-f]{4}-[0-9a-f]{4}-/i, "")
    .replace(/\s+/g, " ")
    .trim();
  return plain === "" ? "Gamepad" : plain.length > LONGEST ? `${plain.slice(0, LONGEST - 1)}…` : plain;
}
