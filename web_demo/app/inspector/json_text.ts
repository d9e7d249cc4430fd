/** JSON as text for people, cut into pieces that can be coloured. Pure. */

export interface JsonPiece {
  readonly kind: "name" | "string" | "literal" | "plain";
  readonly text: string;
}

const TOKEN = /("(?:[^"\\]|\\.)*")(\s*:)?|-?\d+(?:\.\d+)?(?:[eE][+-]?\d+)?|\b(?:true|false|null)\b/g;

/** Returns the pieces of a value's indented text; together they are that text. */
export function jsonPieces(value: unknown): JsonPiece[] {
  const text = JSON.stringify(value, null, 2) ?? "";
  const pieces: JsonPiece[] = [];
  let end = 0;
  const plain = (until: number): void => {
    if (until > end) pieces.push({ kind: "plain", text: text.slice(end, until) });
  };
  for (const match of text.matchAll(TOKEN)) {
    plain(match.index);
    const [whole, string, colon] = match;
    const kind = string === undefined ? "literal" : colon === undefined ? "string" : "name";
    pieces.push({ kind, text: string ?? whole });
    end = match.index + (string ?? whole).length;
  }
  plain(text.length);
  return pieces;
}
