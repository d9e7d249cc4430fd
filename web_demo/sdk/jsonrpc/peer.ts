/**
 * JSON-RPC 2.0 without input or output: text in, events out, text to send.
 *
 * A peer knows which of its own requests are unanswered and how to read and write envelopes; it knows nothing of
 * sockets, time or RoIS. Frame rules beyond the standard: one object per message, no batches, `params` is an
 * object, and an answer to an id that is not outstanding (late, repeated or invented) is a violation.
 */

export type Json = null | boolean | number | string | Json[] | JsonObject;
export type JsonObject = { [name: string]: Json };

/** What may stand in `id`. */
export type RequestId = string | number | null;

export const PARSE_ERROR = -32700;
export const INVALID_REQUEST = -32600;
export const METHOD_NOT_FOUND = -32601;
export const INVALID_PARAMS = -32602;

/** The most characters one incoming message may have. */
export const MAX_MESSAGE_LENGTH = 4 * 1024 * 1024;

export interface ErrorObject {
  readonly code: number;
  readonly message: string;
  readonly data?: Json;
}

export interface Request {
  readonly kind: "request";
  readonly id: RequestId;
  readonly method: string;
  readonly params: JsonObject;
}

export interface Notification {
  readonly kind: "notification";
  readonly method: string;
  readonly params: JsonObject;
}

/** Response to our request `id` for `method`; `id` is no longer outstanding. */
export interface Response {
  readonly kind: "response";
  readonly id: number;
  readonly method: string;
  readonly result: Json;
}

/** Error response to our request `id` for `method`; `id` is no longer outstanding. */
export interface ErrorResponse {
  readonly kind: "error";
  readonly id: number;
  readonly method: string;
  readonly error: ErrorObject;
}

/** Violation of the protocol by the other side. `answer` is null where a response must not be answered. */
export interface Violation {
  readonly kind: "violation";
  readonly reason: string;
  readonly answer: string | null;
}

export type Incoming = Request | Notification | Response | ErrorResponse | Violation;

export const isObject = (value: unknown): value is JsonObject =>
  typeof value === "object" && value !== null && !Array.isArray(value);

const isRequestId = (value: Json | undefined): value is RequestId =>
  value === null || typeof value === "string" || (typeof value === "number" && Number.isFinite(value));

const has = (object: JsonObject, name: string): boolean => Object.hasOwn(object, name);

/** One end of a JSON-RPC 2.0 connection. Ids of our own are integers that are never used twice. */
export class Peer {
  #nextId = 1;
  readonly #outstanding = new Map<number, string>();

  /** How many of our requests have no answer yet. */
  get outstanding(): number {
    return this.#outstanding.size;
  }

  /** Returns a new id and the text of a request for `method`. */
  request(method: string, params: JsonObject): { id: number; text: string } {
    const id = this.#nextId++;
    this.#outstanding.set(id, method);
    return { id, text: JSON.stringify({ jsonrpc: "2.0", id, method, params }) };
  }

  /** Stops expecting a response to the request `id`. */
  abandonRequest(id: number): void {
    this.#outstanding.delete(id);
  }

  /** Returns the text that refuses the request `id`. */
  failure(id: RequestId, code: number, message: string): string {
    return JSON.stringify({ jsonrpc: "2.0", id, error: { code, message } });
  }

  /** Reads one message. Never throws, whatever the text holds. */
  receive(text: string): Incoming {
    if (text.length > MAX_MESSAGE_LENGTH) return this.#violation("the message is too long", PARSE_ERROR);
    let message: unknown;
    try {
      message = JSON.parse(text);
    } catch {
      return this.#violation("the message is not JSON", PARSE_ERROR);
    }
    if (!isObject(message)) return this.#violation("a message is one JSON object", INVALID_REQUEST);
    const id = has(message, "id") ? message["id"] : null;
    if (!isRequestId(id)) return this.#violation("id must be a string, a number or null", INVALID_REQUEST);
    if (message["jsonrpc"] !== "2.0") return this.#violation('jsonrpc must be "2.0"', INVALID_REQUEST, id);
    return has(message, "method") ? this.#readCall(message, id) : this.#readAnswer(message, id);
  }

  #readCall(message: JsonObject, id: RequestId): Incoming {
    const method = message["method"];
    const params = message["params"] ?? {};
    if (typeof method !== "string") return this.#violation("method must be a string", INVALID_REQUEST, id);
    if (isObject(params)) {
      if (!has(message, "id")) return { kind: "notification", method, params };
      return { kind: "request", id, method, params };
    }
    const reason = "params must be an object";
    return has(message, "id")
      ? this.#violation(reason, INVALID_PARAMS, id)
      : { kind: "violation", reason, answer: null };
  }

  #readAnswer(message: JsonObject, id: RequestId): Incoming {
    const withResult = has(message, "result");
    const withError = has(message, "error");
    if (!withResult && !withError) {
      return this.#violation("neither a request nor a response", INVALID_REQUEST, id);
    }
    const method = typeof id === "number" ? this.#outstanding.get(id) : undefined;
    if (typeof id !== "number" || method === undefined) {
      const reason = `an answer to id ${JSON.stringify(id)}, which is not outstanding`;
      return { kind: "violation", reason, answer: null };
    }
    this.#outstanding.delete(id);
    if (!withError) return { kind: "response", id, method, result: message["result"] ?? null };
    const error = withResult ? null : readError(message["error"]);
    const malformed = { code: INVALID_REQUEST, message: "the answer's error object is malformed" };
    return { kind: "error", id, method, error: error ?? malformed };
  }

  #violation(reason: string, code: number, id: RequestId = null): Violation {
    return { kind: "violation", reason, answer: this.failure(id, code, reason) };
  }
}

function readError(value: Json | undefined): ErrorObject | null {
  if (!isObject(value)) return null;
  const { code, message } = value;
  if (!Number.isSafeInteger(code) || typeof message !== "string") return null;
  const error = { code: code as number, message };
  return value["data"] === undefined ? error : { ...error, data: value["data"] };
}
