/** The RoIS 2.0 client: the operations of the System, Command, Query and Event interfaces over one gateway. */

import { INVALID_REQUEST, METHOD_NOT_FOUND, isObject } from "../jsonrpc/peer.ts";
import type { Json, JsonObject, Notification } from "../jsonrpc/peer.ts";
import { RpcError } from "../jsonrpc/session.ts";
import type { JsonRpcSession, Traffic } from "../jsonrpc/session.ts";
import { Emitter } from "../events.ts";
import { Completions } from "./completions.ts";
import { Connection } from "./connection.ts";
import type { ConnectionOptions, ConnectionState } from "./connection.ts";
import { Subscriptions } from "./subscriptions.ts";
import type { Subscription } from "./subscriptions.ts";
import { RoISError, listField, textField } from "./types.ts";
import type {
  CommandUnit,
  Completed,
  ComponentProfile,
  EngineProfile,
  NamedValue,
  Profile,
  ReturnCode,
  RoISEvent,
  RoISFault,
  SequenceItem,
} from "./types.ts";

/** The version of the extensions this client speaks, as `openrois.hello` carries it. */
export const EXTENSION_VERSION = "1";
export const EXTENSIONS: readonly string[] = ["rois.stream", "signaling"];

export interface ClientOptions extends ConnectionOptions {
  /** Milliseconds of silence after which the gateway is asked for a sign of life. */
  readonly idleProbe?: number;
}

export interface ClientEvents {
  state: ConnectionState;
  completed: Completed;
  event: RoISEvent;
  fault: RoISFault;
  /** The engines or components behind the gateway are others now. */
  profile_changed: undefined;
  /** Every notification, also those of extensions. */
  notification: Notification;
  /** Every message that was sent or received. */
  traffic: Traffic;
}

const COMPLETED_WITHIN = 300_000;

/**
 * A RoIS application's end of one gateway. It connects again by itself, and its subscriptions come back with it;
 * reservations (bind) do not, they belong to the session that ended.
 *
 * Every operation throws `RoISError` when its return code is not OK, `RpcError` when the gateway does not know it or
 * its params, and `ConnectionLost` or `RequestTimeout` when there is no answer.
 */
export class RoISClient {
  readonly #events = new Emitter<ClientEvents>();
  readonly #connection: Connection;
  readonly #completions = new Completions();
  readonly #subscriptions: Subscriptions;
  readonly #idleProbe: number;
  #probe: ReturnType<typeof setInterval> | undefined;
  #extensions: readonly string[] | null = null;

  constructor(options: ClientOptions = {}) {
    this.#idleProbe = options.idleProbe ?? 20_000;
    this.#subscriptions = new Subscriptions({
      subscribe: async (eventType, condition) =>
        textField(
          await this.call("rois.event.subscribe", { event_type: eventType, condition }),
          "subscribe_id",
        ),
      unsubscribe: async (subscribeId) => {
        await this.call("rois.event.unsubscribe", { subscribe_id: subscribeId });
      },
    });
    this.#connection = new Connection(options, (session) => this.#handshake(session));
    this.#connection.events.on("state", (state) => this.#stateChanged(state));
    this.#connection.events.on("notification", (notification) => this.#notified(notification));
    this.#connection.events.on("traffic", (traffic) => this.#events.emit("traffic", traffic));
  }

  get state(): ConnectionState {
    return this.#connection.state;
  }

  /** The gateway's extensions beyond RoIS; null where it has none (it does not know `openrois.hello`). */
  get extensions(): readonly string[] | null {
    return this.#extensions;
  }

  /** Listens to one kind of event; the function that comes back ends it. */
  on<Name extends keyof ClientEvents>(name: Name, listener: (value: ClientEvents[Name]) => void): () => void {
    return this.#events.on(name, listener);
  }

  /** Connects and stays connected until `close`; resolves at the first connection. */
  connect(): Promise<void> {
    this.#connection.open();
    if (this.state.name === "connected") return Promise.resolve();
    return new Promise((resolve) => {
      const stop = this.on("state", (state) => {
        if (state.name !== "connected") return;
        stop();
        resolve();
      });
    });
  }

  /** Does not wait for the next attempt: there is reason to believe that it succeeds. */
  retryNow(): void {
    this.#connection.retryNow();
  }

  async close(): Promise<void> {
    if (this.state.name === "connected") await this.call("rois.system.disconnect").catch(() => undefined);
    this.#connection.close();
  }

  /** Calls any method and returns its result once `return_code` is OK. */
  async call(method: string, params: JsonObject = {}): Promise<JsonObject> {
    return checked(method, await this.#connection.request(method, params));
  }

  async getProfile(condition = ""): Promise<Profile> {
    const result = await this.call("rois.system.get_profile", { condition });
    return {
      profile: (result["profile"] ?? null) as EngineProfile | null,
      component_profiles: (result["component_profiles"] ?? {}) as Record<string, ComponentProfile>,
    };
  }

  /** Returns the references of the components that match. */
  async search(condition = ""): Promise<string[]> {
    return listField(await this.call("rois.command.search", { condition }), "component_ref_list");
  }

  /** Reserves a component for this session. Idempotent; OUT_OF_RESOURCES while another session holds it. */
  async bind(componentRef: string): Promise<void> {
    await this.call("rois.command.bind", { component_ref: componentRef });
  }

  async release(componentRef: string): Promise<void> {
    await this.call("rois.command.release", { component_ref: componentRef });
  }

  /**
   * Starts a sequence of commands and returns their ids, in order, once the engine has accepted all of them. Each
   * ends later in `completed`; a refusal starts nothing.
   */
  async execute(sequence: readonly SequenceItem[]): Promise<string[]> {
    const commands: CommandUnit[] = [];
    const identified = (unit: CommandUnit): CommandUnit => {
      const command = { ...unit, command_id: unit.command_id ?? newCommandId() };
      commands.push(command);
      return command;
    };
    const list = sequence.map((item) =>
      "command_list" in item
        ? { ...item, command_list: item.command_list.map(identified) }
        : identified(item),
    );
    const ids = commands.map((command) => command.command_id ?? "");
    for (const id of ids) this.#completions.expect(id);
    try {
      await this.call("rois.command.execute", { command_unit_list: list });
    } catch (error) {
      for (const id of ids) this.#completions.forget(id);
      throw error;
    }
    return ids;
  }

  /**
   * Waits until a command has ended, also if it ended before.
   *
   * @param within milliseconds to wait at most
   * @throws ConnectionLost when the session ended first | RequestTimeout
   */
  completed(commandId: string, within = COMPLETED_WITHIN): Promise<Completed> {
    return this.#completions.wait(commandId, within);
  }

  async getCommandResult(commandId: string): Promise<NamedValue[]> {
    const params = { command_id: commandId, condition: "" };
    return listField(await this.call("rois.command.get_command_result", params), "results");
  }

  /** Asks the one component that answers `queryType` and meets the condition. */
  async query(queryType: string, condition = ""): Promise<NamedValue[]> {
    return listField(await this.call("rois.query.query", { query_type: queryType, condition }), "results");
  }

  /** Hears an event from now on, also after a reconnect. */
  subscribe(
    eventType: string,
    condition: string,
    listener: (event: RoISEvent) => void,
  ): Promise<Subscription> {
    return this.#subscriptions.add(eventType, condition, listener);
  }

  async #handshake(session: JsonRpcSession): Promise<void> {
    checked("rois.system.connect", await session.request("rois.system.connect"));
    const hello = { version: EXTENSION_VERSION, extensions: [...EXTENSIONS] };
    try {
      const answer = checked("openrois.hello", await session.request("openrois.hello", hello));
      this.#extensions = listField<string>(answer, "extensions");
    } catch (error) {
      if (!(error instanceof RpcError && error.code === METHOD_NOT_FOUND)) throw error;
      this.#extensions = null;
    }
  }

  #stateChanged(state: ConnectionState): void {
    clearInterval(this.#probe);
    if (state.name === "connected") {
      this.#probe = setInterval(() => this.#probeIdle(), this.#idleProbe / 4);
      void this.#subscriptions.renew();
    } else {
      this.#completions.lost();
      this.#subscriptions.lost();
    }
    this.#events.emit("state", state);
  }

  /** A browser cannot ping: only an unanswered request shows that a silent connection is dead. */
  #probeIdle(): void {
    if (this.#connection.silence >= this.#idleProbe) void this.search().catch(() => undefined);
  }

  #notified(notification: Notification): void {
    const { method, params } = notification;
    switch (method) {
      case "rois.command.completed": {
        const completed = params as unknown as Completed;
        this.#completions.completed(completed);
        this.#events.emit("completed", completed);
        break;
      }
      case "rois.event.notify_event": {
        const event = { expire: "", results: [], ...params } as unknown as RoISEvent;
        this.#subscriptions.deliver(event);
        this.#events.emit("event", event);
        break;
      }
      case "rois.system.notify_error":
        this.#events.emit("fault", params as unknown as RoISFault);
        break;
      case "rois.system.profile_changed":
        void this.#subscriptions.renew();
        this.#events.emit("profile_changed", undefined);
        break;
    }
    this.#events.emit("notification", notification);
  }
}

/** @throws RoISError when the return code is not OK | RpcError when there is none */
function checked(method: string, result: Json): JsonObject {
  if (!isObject(result) || typeof result["return_code"] !== "string") {
    throw new RpcError({ code: INVALID_REQUEST, message: "the result has no return_code" }, method);
  }
  if (result["return_code"] !== "OK") throw new RoISError(result["return_code"] as ReturnCode, method);
  return result;
}

/** `crypto.randomUUID` exists on secure origins only; a page over plain HTTP on a LAN is none. */
function newCommandId(): string {
  const bytes = crypto.getRandomValues(new Uint8Array(12));
  return `command-${Array.from(bytes, (byte) => byte.toString(16).padStart(2, "0")).join("")}`;
}
