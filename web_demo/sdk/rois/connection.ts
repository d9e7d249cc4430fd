/** Connection to one gateway that reconnects by itself. */

import { Emitter } from "../jsonrpc/events.ts";
import { ConnectionLost, JsonRpcSession } from "../jsonrpc/session.ts";
import type { SocketLike, Traffic } from "../jsonrpc/session.ts";
import type { Json, JsonObject, Notification } from "../jsonrpc/peer.ts";
import { Backoff } from "./backoff.ts";
import type { BackoffOptions } from "./backoff.ts";

/** State of the connection. */
export type ConnectionState =
  /** `attempt` counts the failures since the connection was last good; 0 at the first try. */
  | { readonly name: "connecting"; readonly attempt: number }
  | { readonly name: "connected" }
  /**
   * The next attempt starts at `retryAt`, in milliseconds since the epoch; infinite for none by itself. `code` is that of
   * the socket that has closed, if there was one.
   */
  | {
      readonly name: "waiting";
      readonly retryAt: number;
      readonly attempt: number;
      readonly reason: string;
      readonly code?: number;
    }
  | { readonly name: "closed" };

export interface ConnectionEvents {
  state: ConnectionState;
  notification: Notification;
  traffic: Traffic;
}

export interface ConnectionOptions {
  /**
   * A JSON Web Token, or what returns the newest: it is called at every connection, and before the present one ends.
   * A page sends it as a subprotocol, for browsers set no headers; all others in the header `Authorization`. It is never
   * in the URL, where logs would keep it.
   */
  readonly token?: string | (() => string | undefined);
  /** How long to wait between attempts. */
  readonly backoff?: BackoffOptions;
  /** Milliseconds a socket may take to open. */
  readonly connectTimeout?: number;
  /** Milliseconds after which an unanswered request fails. */
  readonly requestTimeout?: number;
  /**
   * Opens a WebSocket, a function and not the class; by default the one of the platform. Node has one from 22 on; for
   * Node 20, with `ws`: `(url, protocols, headers) => new WebSocket(url, protocols, { headers })`.
   */
  readonly webSocket?: (
    url: string,
    protocols: string[],
    headers: Readonly<Record<string, string>>,
  ) => SocketLike;
}

/** A connection that lived this long (ms) was a good one: the next failure is counted as the first. */
const GOOD_AFTER = 10_000;

/**
 * Opens a socket, runs `handshake` on it, and starts again whenever either fails or the socket closes.
 *
 * A close with the reason `retry_after=<seconds>`, which a gateway sends when it is about to restart, is obeyed.
 */
export class Connection {
  readonly events = new Emitter<ConnectionEvents>();
  readonly #url: string;
  readonly #options: ConnectionOptions;
  readonly #handshake: (session: JsonRpcSession) => Promise<void>;
  readonly #backoff: Backoff;
  #state: ConnectionState = { name: "closed" };
  #session: JsonRpcSession | null = null;
  #timer: ReturnType<typeof setTimeout> | undefined;
  #attempt = 0;

  /** @throws TypeError when `url` is no address, nothing here can open a WebSocket, or the option does not */
  constructor(
    url: string | URL,
    options: ConnectionOptions,
    handshake: (session: JsonRpcSession) => Promise<void>,
  ) {
    requireOpener(options.webSocket);
    if (!options.webSocket && !("WebSocket" in globalThis)) {
      throw new TypeError("there is no WebSocket here: give the option webSocket, or use Node 22 or later");
    }
    this.#url = gatewayUrl(url);
    this.#options = options;
    this.#handshake = handshake;
    this.#backoff = new Backoff(options.backoff);
  }

  get state(): ConnectionState {
    return this.#state;
  }

  /** Milliseconds since the last message of the gateway; infinite without a connection. */
  get silence(): number {
    return this.#session?.silence ?? Number.POSITIVE_INFINITY;
  }

  open(): void {
    if (this.#state.name === "closed") this.#dial();
  }

  /** Cuts a wait short: the next attempt starts now. */
  retryNow(): void {
    if (this.#state.name === "waiting") this.#dial();
  }

  /** Makes no further attempt before `retryNow`, since none would succeed. */
  hold(): void {
    if (this.#state.name !== "waiting") return;
    clearTimeout(this.#timer);
    this.#enter({ ...this.#state, retryAt: Number.POSITIVE_INFINITY });
  }

  /** Closes a connection that is taken for dead after a long silence; the next one is made. */
  abandon(): void {
    this.#session?.close(4000, "no answer");
  }

  close(): void {
    this.#attempt += 1;
    clearTimeout(this.#timer);
    this.#enter({ name: "closed" });
    this.#session?.close(1000, "client closed");
    this.#session = null;
  }

  /** @throws RpcError | ConnectionLost | RequestTimeout */
  request(
    method: string,
    params: JsonObject,
    onLate?: (result: Json) => void,
    onReason?: (reason: string) => void,
  ): Promise<Json> {
    if (this.#session && this.#state.name === "connected")
      return this.#session.request(method, params, onLate, onReason);
    return Promise.reject(new ConnectionLost(`${method}: there is no connection`));
  }

  /** Passes on why a request is about to be refused. */
  explain(id: number, reason: string): void {
    this.#session?.explain(id, reason);
  }

  #dial(): void {
    const attempt = ++this.#attempt;
    clearTimeout(this.#timer);
    this.#enter({ name: "connecting", attempt: this.#backoff.failures });
    let socket: SocketLike;
    try {
      socket = requireSocket(this.#createSocket());
    } catch (error) {
      return this.#fail(attempt, error instanceof Error ? error.message : String(error));
    }
    this.#timer = setTimeout(() => {
      this.#fail(attempt, "the gateway did not answer in time");
      socket.close();
    }, this.#options.connectTimeout ?? 10_000);
    socket.addEventListener("open", () => {
      if (attempt === this.#attempt) void this.#welcome(attempt, socket);
      else socket.close();
    });
    // `ws` throws errors without a listener, and says why there is no connection; a browser does not.
    socket.addEventListener("error", ({ message }) => {
      if (message) this.#fail(attempt, message);
    });
    socket.addEventListener("close", (event) =>
      this.#fail(attempt, event.reason || `closed (${event.code})`, event.code),
    );
  }

  async #welcome(attempt: number, socket: SocketLike): Promise<void> {
    clearTimeout(this.#timer);
    const { requestTimeout } = this.#options;
    const session = new JsonRpcSession(socket, {
      ...(requestTimeout !== undefined && { requestTimeout }),
      onNotification: (notification) => {
        if (attempt === this.#attempt) this.events.emit("notification", notification);
      },
      onTraffic: (traffic) => this.events.emit("traffic", traffic),
      onClose: (code, reason) => this.#fail(attempt, reason || `closed (${code})`, code),
    });
    this.#session = session;
    try {
      await this.#handshake(session);
    } catch (error) {
      const reason = error instanceof Error ? error.message : String(error);
      this.#fail(attempt, reason);
      return session.close(4001, "handshake failed");
    }
    if (attempt !== this.#attempt) return;
    this.#timer = setTimeout(() => this.#backoff.reset(), GOOD_AFTER);
    this.#enter({ name: "connected" });
  }

  #fail(attempt: number, reason: string, code?: number): void {
    // An attempt that was given up is ignored.
    if (attempt !== this.#attempt) return;
    this.#attempt += 1;
    clearTimeout(this.#timer);
    this.#session = null;
    const asked = /^retry_after=(\d{1,4}(?:\.\d+)?)$/.exec(reason)?.[1];
    // Both: a time that all clients get alike must not bring them back at the same moment.
    const wait = this.#backoff.next() + (asked === undefined ? 0 : Number(asked) * 1000);
    const retryAt = Date.now() + wait;
    this.#timer = setTimeout(() => this.#dial(), wait);
    const closed = code === undefined ? {} : { code };
    this.#enter({ name: "waiting", retryAt, attempt: this.#backoff.failures, reason, ...closed });
  }

  #enter(state: ConnectionState): void {
    this.#state = state;
    this.events.emit("state", state);
  }

  #createSocket(): SocketLike {
    const { token: given, webSocket = openWebSocket } = this.#options;
    const token = typeof given === "function" ? given() : given;
    if (token === undefined) return webSocket(this.#url, [], {});
    if (!/^[!-~]+$/.test(token))
      throw new TypeError("the token must be one line of printable ASCII characters without spaces");
    return "location" in globalThis
      ? webSocket(this.#url, ["openrois.v1", `openrois.bearer.${token}`], {})
      : webSocket(this.#url, [], { Authorization: `Bearer ${token}` });
  }
}

/** Returns the WebSocket address that belongs to `url`, which is read relative to the page. */
export function gatewayUrl(url: string | URL, base: string | undefined = globalThis.location?.href): string {
  const address = URL.canParse(url, base) ? new URL(url, base) : undefined;
  if (!address || !/^(ws|http)s?:$/.test(address.protocol))
    throw new TypeError(`"${url}" is not the address of a gateway: give one such as ws://127.0.0.1:8765/`);
  address.protocol = address.protocol.replace(/^http/, "ws");
  address.hash = "";
  return address.href;
}

const OPENER = "webSocket must be a function such as (url, protocols) => new WebSocket(url, protocols)";

/** Refuses what cannot be called for a socket: a class, above all, which has to be called with `new`. */
function requireOpener(given: unknown): void {
  if (given === undefined) return;
  if (typeof given !== "function")
    throw new TypeError(`${OPENER}, not ${given === null ? "null" : typeof given}`);
  const prototype: unknown = given.prototype;
  // A class may also be a function that was compiled from one; a socket's has `send`.
  const isSocket = typeof prototype === "object" && prototype !== null && "send" in prototype;
  if (isSocket || /^class\b/.test(Function.prototype.toString.call(given)))
    throw new TypeError(`${OPENER}, not the class ${given.name}`);
}

/** Refuses what a function that opens sockets returned, where it is none. */
function requireSocket(made: SocketLike | undefined): SocketLike {
  if (typeof made?.addEventListener === "function") return made;
  throw new TypeError(`${OPENER}, and return a socket with addEventListener`);
}

function openWebSocket(
  url: string,
  protocols: string[],
  headers: Readonly<Record<string, string>>,
): SocketLike {
  // Outside of browsers the second argument may be an object; TypeScript's own types are those of a page.
  return new WebSocket(url, "Authorization" in headers ? ({ headers } as unknown as string[]) : protocols);
}
