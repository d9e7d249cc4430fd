/** JSON-RPC session over one WebSocket: waiters, time limits, and a hook that sees every message. */

import { METHOD_NOT_FOUND, Peer, isObject } from "./peer.ts";
import type { ErrorObject, Json, JsonObject, Notification } from "./peer.ts";

/** The part of the browser's WebSocket that a session uses; `ws` of Node has the same. */
export interface SocketLike {
  readonly readyState: number;
  readonly bufferedAmount: number;
  send(text: string): void;
  close(code?: number, reason?: string): void;
  addEventListener(type: "open", listener: () => void): void;
  addEventListener(type: "error", listener: (event: { message?: string }) => void): void;
  addEventListener(type: "message", listener: (event: { data: unknown }) => void): void;
  addEventListener(type: "close", listener: (event: { code: number; reason: string }) => void): void;
}

/** A message that was sent or received, as an observer sees it. */
export interface Traffic {
  readonly direction: "sent" | "received";
  /** Milliseconds since the epoch. */
  readonly at: number;
  readonly kind: "request" | "notification" | "response" | "error" | "violation";
  /** The method; for an answer that of its request, for a violation the empty string. */
  readonly method: string;
  /** For an answer: the milliseconds since its request was sent. */
  readonly elapsed?: number;
  /** The whole message; for a violation the sentence that says what was wrong. */
  readonly message: Json;
}

export interface SessionOptions {
  /** Milliseconds after which an unanswered request fails. */
  readonly requestTimeout?: number;
  /** The most requests that may be unanswered at one time. */
  readonly maxOutstanding?: number;
  readonly onNotification?: (notification: Notification) => void;
  readonly onTraffic?: (traffic: Traffic) => void;
  readonly onClose?: (code: number, reason: string) => void;
}

/** JSON-RPC error response: unknown method, wrong params, or a fault in the engine. */
export class RpcError extends Error {
  override readonly name = "RpcError";
  readonly code: number;
  readonly method: string;
  readonly data: Json | undefined;

  constructor(error: ErrorObject, method: string) {
    super(`${method}: ${error.message} (${error.code})${details(error.data)}`);
    this.code = error.code;
    this.method = method;
    this.data = error.data;
  }
}

/** No connection, or it ended before the response came. */
export class ConnectionLost extends Error {
  override readonly name = "ConnectionLost";
}

/** No response in time, or too many requests without one. */
export class RequestTimeout extends Error {
  override readonly name = "RequestTimeout";
}

const OPEN = 1;
const MAX_BUFFERED_BYTES = 1024 * 1024;
/** Most late responses that are still accepted; the oldest is given up first. */
const MAX_LATE = 64;

type OnLate = (result: Json) => void;
type OnReason = (reason: string) => void;

interface Waiter {
  readonly method: string;
  readonly sentAt: number;
  readonly timer: ReturnType<typeof setTimeout>;
  resolve(result: Json): void;
  reject(error: Error): void;
  readonly onLate: OnLate | undefined;
  readonly onReason: OnReason | undefined;
}

/** Owns an open socket until it closes; after that every call fails with `ConnectionLost`. */
export class JsonRpcSession {
  readonly #peer = new Peer();
  readonly #waiters = new Map<number, Waiter>();
  readonly #late = new Map<number, OnLate>();
  readonly #socket: SocketLike;
  readonly #options: SessionOptions;
  readonly #requestTimeout: number;
  readonly #maxOutstanding: number;
  #receivedAt = performance.now();
  #closed = false;

  constructor(socket: SocketLike, options: SessionOptions = {}) {
    this.#socket = socket;
    this.#options = options;
    this.#requestTimeout = options.requestTimeout ?? 10_000;
    this.#maxOutstanding = options.maxOutstanding ?? 64;
    socket.addEventListener("message", (event) => this.#receive(event.data));
    socket.addEventListener("close", (event) => this.#failWaiters(event.code, event.reason));
  }

  /** Milliseconds since the last message came in. */
  get silence(): number {
    return performance.now() - this.#receivedAt;
  }

  /**
   * Asks `method` and waits for its result.
   *
   * @param onLate is called with a result that comes after `RequestTimeout`, to undo what was done
   * @param onReason is called with the reason that `explain` gives for this request, before its result comes
   * @throws RpcError | ConnectionLost | RequestTimeout
   */
  request(method: string, params: JsonObject = {}, onLate?: OnLate, onReason?: OnReason): Promise<Json> {
    return new Promise((resolve, reject) => {
      if (this.#closed || this.#socket.readyState !== OPEN) {
        return reject(new ConnectionLost(`${method}: there is no connection`));
      }
      if (this.#waiters.size >= this.#maxOutstanding || this.#socket.bufferedAmount > MAX_BUFFERED_BYTES) {
        return reject(
          new RequestTimeout(`${method}: too many requests are unanswered: await some responses first`),
        );
      }
      const { id, text } = this.#peer.request(method, params);
      const timer = setTimeout(() => this.#expire(id), this.#requestTimeout);
      this.#waiters.set(id, { method, sentAt: performance.now(), timer, resolve, reject, onLate, onReason });
      this.#socket.send(text);
      this.#observe("sent", "request", method, () => ({ jsonrpc: "2.0", id, method, params }));
    });
  }

  /** Passes on why a request is about to be refused; ignored for a request without a waiter. */
  explain(id: number, reason: string): void {
    this.#waiters.get(id)?.onReason?.(reason);
  }

  /** Closes the socket and fails every waiter at once, without waiting for the other side. */
  close(code: number, reason: string): void {
    this.#socket.close(code, reason);
    this.#failWaiters(code, reason);
  }

  #receive(data: unknown): void {
    if (this.#closed) return;
    this.#receivedAt = performance.now();
    if (typeof data !== "string") return this.close(4003, "binary message");
    const incoming = this.#peer.receive(data);
    switch (incoming.kind) {
      case "notification":
        this.#observe("received", "notification", incoming.method, () => parsed(data));
        this.#options.onNotification?.(incoming);
        return;
      case "request":
        // An engine has nothing to ask of an application.
        this.#observe("received", "request", incoming.method, () => parsed(data));
        this.#socket.send(this.#peer.failure(incoming.id, METHOD_NOT_FOUND, "Method not found"));
        return;
      case "violation":
        this.#observe("received", "violation", "", () => incoming.reason);
        if (incoming.answer !== null) this.#socket.send(incoming.answer);
        return;
      default: {
        const waiter = this.#removeWaiter(incoming.id);
        const elapsed = waiter && performance.now() - waiter.sentAt;
        this.#observe("received", incoming.kind, incoming.method, () => parsed(data), elapsed);
        if (incoming.kind === "response") (waiter?.resolve ?? this.#late.get(incoming.id))?.(incoming.result);
        else waiter?.reject(new RpcError(incoming.error, incoming.method));
        this.#late.delete(incoming.id);
      }
    }
  }

  #expire(id: number): void {
    const waiter = this.#removeWaiter(id);
    if (waiter?.onLate) this.#late.set(id, waiter.onLate);
    else this.#peer.abandonRequest(id);
    const oldest = this.#late.keys().next();
    if (this.#late.size > MAX_LATE && !oldest.done) {
      this.#late.delete(oldest.value);
      this.#peer.abandonRequest(oldest.value);
    }
    waiter?.reject(new RequestTimeout(`${waiter.method}: no answer within ${this.#requestTimeout} ms`));
    // A socket on which nothing at all comes in any more is dead, though the browser cannot know it yet.
    if (this.silence >= this.#requestTimeout) this.close(4000, "no answer");
  }

  #removeWaiter(id: number): Waiter | undefined {
    const waiter = this.#waiters.get(id);
    this.#waiters.delete(id);
    if (waiter) clearTimeout(waiter.timer);
    return waiter;
  }

  #failWaiters(code: number, reason: string): void {
    if (this.#closed) return;
    this.#closed = true;
    for (const id of [...this.#waiters.keys()]) {
      const waiter = this.#removeWaiter(id);
      waiter?.reject(new ConnectionLost(`${waiter.method}: the connection ended (${code} ${reason})`));
    }
    this.#options.onClose?.(code, reason);
  }

  #observe(
    direction: Traffic["direction"],
    kind: Traffic["kind"],
    method: string,
    message: () => Json,
    elapsed?: number,
  ): void {
    if (!this.#options.onTraffic) return;
    const traffic = { direction, at: Date.now(), kind, method, message: message() };
    this.#options.onTraffic(elapsed === undefined ? traffic : { ...traffic, elapsed });
  }
}

/** Parses a message again: the observer's copy cannot change the application's. */
function parsed(text: string): Json {
  const value: unknown = JSON.parse(text);
  return isObject(value) ? value : null;
}

/** Errors in params, `[{path, message}]`, as the end of a sentence; `data` may be any JSON. */
function details(data: Json | undefined): string {
  const wrong = (Array.isArray(data) ? data : []) as readonly ({ path?: Json; message?: Json } | null)[];
  const parts = wrong.slice(0, 3).map((each) => `${String(each?.path)}: ${String(each?.message)}`);
  return parts.length > 0 ? `: ${parts.join("; ").slice(0, 300)}` : "";
}
