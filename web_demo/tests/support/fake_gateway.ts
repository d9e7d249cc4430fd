/** A gateway without a network: sockets that lead to a table of methods. For tests, and for work on the page. */

import type { JsonObject } from "../../sdk/jsonrpc/peer.ts";
import type { SocketLike } from "../../sdk/jsonrpc/session.ts";

type Method = (params: JsonObject, id: number) => JsonObject | Promise<JsonObject>;
type Listener = (event: never) => void;

/** Thrown by a method: answered as a JSON-RPC error. */
export class Refusal extends Error {
  readonly code: number;

  constructor(code: number, message: string) {
    super(message);
    this.code = code;
  }
}

export class FakeSocket implements SocketLike {
  readyState = 0;
  bufferedAmount = 0;
  readonly url: string;
  readonly protocols: readonly string[];
  readonly #listeners = new Map<string, Listener[]>();
  readonly #receive: (socket: FakeSocket, text: string) => void;

  constructor(
    url: string,
    protocols: readonly string[],
    receive: (socket: FakeSocket, text: string) => void,
  ) {
    this.url = url;
    this.protocols = protocols;
    this.#receive = receive;
  }

  addEventListener(type: string, listener: Listener): void {
    this.#listeners.set(type, [...(this.#listeners.get(type) ?? []), listener]);
  }

  send(text: string): void {
    if (this.readyState === 1) this.#receive(this, text);
  }

  /** What the application calls. */
  close(code = 1005, reason = ""): void {
    this.endSocket(code, reason);
  }

  open(): void {
    this.readyState = 1;
    this.#emit("open", {});
  }

  /** Delivers a message to the application. */
  deliver(data: unknown): void {
    if (this.readyState === 1) this.#emit("message", { data });
  }

  /** Says what is wrong, as the sockets of `ws` do. */
  fail(message: string): void {
    this.#emit("error", { message });
  }

  /** Ends the socket as the network or the gateway would. */
  endSocket(code: number, reason = ""): void {
    if (this.readyState === 3) return;
    this.readyState = 3;
    this.#emit("close", { code, reason });
  }

  #emit(type: string, event: object): void {
    for (const listener of this.#listeners.get(type) ?? []) listener(event as never);
  }
}

/** Answers through `methods`; what it does not know is -32601, as everywhere. */
export class FakeGateway {
  readonly methods = new Map<string, Method>();
  readonly calls: { method: string; params: JsonObject }[] = [];
  readonly sockets: FakeSocket[] = [];
  /** The gateway runs: sockets open. */
  running = true;
  /** The gateway is stuck: it takes requests and answers none. */
  mute = false;

  constructor(extensions: string[] | null = ["rois.stream", "signaling"]) {
    this.on("rois.system.connect", () => ({}));
    this.on("rois.system.disconnect", () => ({}));
    this.on("rois.command.search", () => ({ component_ref_list: [] }));
    if (extensions) {
      this.on("openrois.hello", () => ({ version: "1", extensions, client_id: "fake" }));
      this.on("signaling.ice_servers", () => ({ ice_servers: [], ttl: 3600 }));
    }
  }

  /** Sets what a method answers; `return_code` is OK unless it says otherwise. */
  on(method: string, answer: Method): this {
    this.methods.set(method, answer);
    return this;
  }

  /** Returns the params of every call of a method so far. */
  called(method: string): JsonObject[] {
    return this.calls.filter((call) => call.method === method).map((call) => call.params);
  }

  get socket(): FakeSocket {
    const socket = this.sockets.at(-1);
    if (!socket) throw new Error("no client has connected: connect one first");
    return socket;
  }

  /** The headers that the last connection was opened with. */
  headers: Readonly<Record<string, string>> = {};

  readonly webSocket = (
    url: string,
    protocols: readonly string[],
    headers: Readonly<Record<string, string>> = {},
  ): FakeSocket => {
    this.headers = headers;
    const socket = new FakeSocket(url, protocols, (from, text) => void this.#receive(from, text));
    this.sockets.push(socket);
    queueMicrotask(() => (this.running ? socket.open() : socket.endSocket(1006)));
    return socket;
  };

  notify(method: string, params: JsonObject): void {
    this.socket.deliver(JSON.stringify({ jsonrpc: "2.0", method, params }));
  }

  stop(code = 1006, reason = ""): void {
    this.running = false;
    this.sockets.at(-1)?.endSocket(code, reason);
  }

  async #receive(socket: FakeSocket, text: string): Promise<void> {
    const { id, method, params } = JSON.parse(text) as { id: number; method: string; params: JsonObject };
    this.calls.push({ method, params });
    if (this.mute) return;
    const answer = this.methods.get(method);
    try {
      if (!answer) throw new Refusal(-32601, "Method not found");
      const result = { return_code: "OK", ...(await answer(params, id)) };
      socket.deliver(JSON.stringify({ jsonrpc: "2.0", id, result }));
    } catch (error) {
      const code = error instanceof Refusal ? error.code : -32603;
      socket.deliver(JSON.stringify({ jsonrpc: "2.0", id, error: { code, message: String(error) } }));
    }
  }
}
