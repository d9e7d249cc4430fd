/** Places in the inspector as parts of the page's address. Pure. */

const ROOT = "#inspector";

/** Returns the address of an engine, of a component, or with an empty id of the inspector itself. */
export function addressOf(id: string): string {
  return [ROOT, ...id.split("/").filter(Boolean).map(encodeURIComponent)].join("/");
}

/** Returns the id that an address leads to; null when it does not lead into the inspector. */
export function idOf(address: string): string | null {
  const [root, ...parts] = address.split("/");
  if (root !== ROOT) return null;
  try {
    return parts.map(decodeURIComponent).join("/");
  } catch {
    return "";
  }
}
