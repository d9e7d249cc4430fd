/** Words for the codes of the wire, none of which the page shows as it is. Pure. */

const WORDS: ReadonlyMap<string, string> = new Map(
  Object.entries({
    // Return codes, and how commands end.
    OK: "OK",
    ERROR: "failed",
    BAD_PARAMETER: "not accepted",
    UNSUPPORTED: "not available",
    OUT_OF_RESOURCES: "refused",
    TIMEOUT: "not in time",
    ABORT: "stopped",
    // Errors of JSON-RPC.
    "-32601": "not served",
    "-32602": "not understood",
    "-32603": "failed",
    // Streams.
    STREAMING_RUNNING: "running",
    STREAMING_RESUMED: "running",
    STREAMING_SUSPENDED: "suspended",
    STREAMING_NOT_RUNNING: "not running",
    STREAMING_NOT_CONNECTED: "not connected",
    // Control of a component.
    FREE: "free",
    MINE: "yours",
    HELD: "in use",
    ABSENT: "in use, connection lost",
    // Kinds of errors.
    ENGINE_INTERNAL_ERROR: "engine failed",
    COMPONENT_INTERNAL_ERROR: "component failed",
    COMPONENT_NOT_RESPONDING: "component does not answer",
    USER_DEFINED_ERROR: "reported by the component",
  }),
);

/** Returns what a code means, in small letters; of an unknown one its own words. */
export function codeWords(code: string): string {
  return WORDS.get(code) ?? nameWords(code).toLowerCase();
}

/** Returns a name of the wire as words: `speech_text` is `speech text`. */
export function nameWords(name: string): string {
  return name.replaceAll("_", " ");
}

/** Returns what a component is called: the last part of its reference. */
export function componentWords(componentRef: string): string {
  return nameWords(componentRef.split("/").at(-1) ?? "");
}
