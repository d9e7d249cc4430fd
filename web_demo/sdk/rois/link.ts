/** An application's end of one gateway: connects and reconnects, calls methods, takes notifications. */

import { Emitter } from "../jsonrpc/events.ts";
import { METHOD_NOT_FOUND } from "../jsonrpc/peer.ts";
import type { Json, JsonObject, Notification } from "../jsonrpc/peer.ts";
import { ConnectionLost, RpcError } from "../jsonrpc/session.ts";
import type { JsonRpcSession, Traffic } from "../jsonrpc/session.ts";
import { wrongInNotification, wrongInResult } from "./checks.ts";
import type { Claim, LentClaim, LostClaim } from "./claims.ts";
import { Connection } from "./connection.ts";
import type { ConnectionOptions, ConnectionState } from "./connection.ts";
import { DIRECTORY } from "./engine_directory.ts";
import { InvalidMessage, RoISError } from "./errors.ts";
import type { ExtensionMethods } from "./extension_methods.ts";
import type { ProfileChange } from "./profile_change.ts";
import type { BodyLoss } from "./reserving.ts";
import type { IsStopped } from "./stops.ts";
import type { MethodName, Methods } from "./generated/methods.ts";
import type {
  Completed,
  DirectoryChangedNotification,
  ErrorNotification,
  EventNotification,
  EventsDroppedNotification,
  ReasonNotification,
  ReturnCode,
} from "./generated/types.ts";

/** The version of the extensions this client speaks, as `openrois.hello` carries it. */
const EXTENSION_VERSION = "1";
const EXTENSIONS: readonly string[] = ["rois.stream", "signaling", DIRECTORY];

/** Milliseconds that a gateway has for a sign of life when the network may be another one. */
const SIGN_WITHIN = 3000;

/** The name of a method that may be called: one of the wire, or of an extension that was declared. */
export type CallName = MethodName | keyof ExtensionMethods;

/** What a declared method carries; a declaration without it carries any object. */
type Carried<Method extends CallName, Part extends "params" | "result"> = Method extends MethodName
  ? Methods[Method][Part]
  : Method extends keyof ExtensionMethods
    ? ExtensionMethods[Method] extends { readonly [Each in Part]: infer Told }
      ? Told
      : JsonObject
    : never;

/** The params of a method. */
export type Params<Method extends CallName> = Carried<Method, "params">;

/** The result of a method. */
export type ResultOf<Method extends CallName> = Carried<Method, "result">;

/** Is called with the result of a call that had ended with `RequestTimeout`, to undo what was done. */
export type Late<Method extends CallName> = (result: ResultOf<Method>) => void;

/** Calls a method, and returns its result once the `return_code` is OK. Params may be left out where all may. */
export type Call = <Method extends CallName>(
  method: Method,
  ...params: {} extends Params<Method>
    ? [params?: Params<Method>, late?: Late<Method>]
    : [params: Params<Method>, late?: Late<Method>]
) => Promise<ResultOf<Method>>;

/** An event as an application gets it: what the engine left out is empty. */
export type RoISEvent = Required<EventNotification>;

/** How a command has ended. */
export interface Ended extends Completed {
  /** Why it did not end OK; absent where no reason was given. */
  readonly reason?: string;
}

/** How a client connects. */
export interface ClientOptions extends ConnectionOptions {
  /** Milliseconds of silence after which the gateway is asked for a sign of life. */
  readonly idleProbe?: number;
}

/** Events of a client. */
export interface ClientEvents {
  /** Connected, waiting, closed ... */
  state: ConnectionState;
  /** A command has ended. */
  completed: Ended;
  /** An event happened; `subscribe` passes on those of one kind. */
  event: RoISEvent;
  /** An engine or component reports a fault; `getErrorDetail` returns more. */
  fault: ErrorNotification;
  /** So many events and faults were dropped here, because this application reads too slowly. */
  dropped: number;
  /** The engines or components behind the gateway have changed. */
  profile_changed: ProfileChange;
  /** A binding or subscription is gone and could not be made again, or another application has the component now. */
  lost: LostClaim;
  /** An application of higher rank has taken what was bound for a time: `restored` follows, or `lost`. */
  lent: LentClaim;
  /** A binding or subscription was gone and is made again; what happened in between is not known. */
  restored: Claim;
  /** An invalid message was ignored; a sentence says what is wrong with it. */
  invalid: string;
  /**
   * What acts on an engine is stopped, by `control.stopAll` of this client or by a person, where the gateway notifies this
   * client of that; the value tells of a component whether it is meant.
   */
  stopped: IsStopped;
  /** A body that was reserved is not any more; what was left of it is released. */
  body_lost: BodyLoss;
  /** Every notification, also those of extensions. */
  notification: Notification;
  /** Every message that was sent or received. */
  traffic: Traffic;
}

/** The connection of a `Client`, below the operations of RoIS. */
export abstract class Link {
  protected readonly emitter = new Emitter<ClientEvents>();
  readonly #connection: Connection;
  readonly #idleProbe: number;
  readonly #newest: () => string | undefined;
  /** The token that the gateway was shown last. */
  #shown: string | undefined;
  #probe: ReturnType<typeof setInterval> | undefined;
  #doubt: ReturnType<typeof setTimeout> | undefined;
  #extensions: readonly string[] | null = null;
  #postponed: (() => void)[] = [];
  /** Reason of the command that is reported next. */
  #reason: ReasonNotification | null = null;

  /**
   * @param url the gateway, `ws://`, `wss://` or what it prints, `http://`; read relative to the page
   * @throws TypeError when `url` is no address, there is no WebSocket here and no `webSocket` is given, or that is a class
   */
  constructor(url: string | URL = "./", options: ClientOptions = {}) {
    this.#idleProbe = options.idleProbe ?? 20_000;
    const { token } = options;
    // A token that was read from a file has a line end.
    this.#newest = () => (typeof token === "function" ? token() : token)?.trim();
    const show = (): string | undefined => (this.#shown = this.#newest());
    this.#connection = new Connection(url, { ...options, token: show }, (session) =>
      this.#handshake(session),
    );
    this.#connection.events.on("state", (state) => this.#stateChanged(state));
    this.#connection.events.on("notification", (notification) => this.#notified(notification));
    this.#connection.events.on("traffic", (traffic) => this.emitter.emit("traffic", traffic));
  }

  /** Whether there is a connection, and when the next attempt is made. */
  get state(): ConnectionState {
    return this.#connection.state;
  }

  /** The gateway's extensions beyond RoIS; null where it has none (it does not know `openrois.hello`). */
  get extensions(): readonly string[] | null {
    return this.#extensions;
  }

  /** Listens to events of the client and returns the function that ends it. */
  on<Name extends keyof ClientEvents>(name: Name, listener: (value: ClientEvents[Name]) => void): () => void {
    return this.emitter.on(name, listener);
  }

  /**
   * Connects and stays connected until `close`; resolves at the first connection. While there is no gateway it keeps
   * trying; `on("state")` says why, and `signal` ends it, such as `AbortSignal.timeout(5000)`.
   *
   * @throws ConnectionLost when the client is closed first | the reason of `signal`
   */
  connect({ signal }: { readonly signal?: AbortSignal } = {}): Promise<void> {
    if (signal?.aborted) return Promise.reject(signal.reason);
    this.#connection.open();
    if (this.state.name === "connected") return Promise.resolve();
    return new Promise((resolve, reject) => {
      const abort = (): void => {
        stop();
        void this.close();
        reject(signal?.reason);
      };
      const stop = this.on("state", ({ name }) => {
        if (name !== "connected" && name !== "closed") return;
        stop();
        signal?.removeEventListener("abort", abort);
        if (name === "connected") resolve();
        else reject(new ConnectionLost("the client was closed"));
      });
      signal?.addEventListener("abort", abort, { once: true });
    });
  }

  /** Makes the next attempt at once. */
  retryNow(): void {
    this.#connection.retryNow();
  }

  /** While there is no connection: makes no further attempt before `retryNow`, such as with another token. */
  hold(): void {
    this.#connection.hold();
  }

  /**
   * Checks the connection, since the network may have changed: connects anew unless the gateway answers within three
   * seconds.
   */
  networkChanged(): void {
    this.retryNow();
    if (this.state.name !== "connected") return;
    void this.call("rois.command.search").catch(() => undefined);
    const asked = performance.now();
    clearTimeout(this.#doubt);
    this.#doubt = setTimeout(() => {
      if (this.#connection.silence > performance.now() - asked) this.#connection.abandon();
    }, SIGN_WITHIN);
  }

  /** Ends the session, and with it what was bound and subscribed. */
  async close(): Promise<void> {
    if (this.state.name === "connected") await this.call("rois.system.disconnect").catch(() => undefined);
    this.#connection.close();
  }

  /**
   * Calls a method of the wire, or one that is declared in `ExtensionMethods`, and returns its result once `return_code`
   * is OK. TypeScript refuses any other name.
   *
   * @throws RoISError | RpcError | InvalidMessage | ConnectionLost | RequestTimeout
   */
  readonly call: Call = (method, ...[params, late]) => ask(this.#connection, method, params, late);

  /** Reports an invalid message that was ignored. @internal */
  passedOver(what: string): void {
    this.emitter.emit("invalid", what);
  }

  /** Calls `report` as soon as there is a connection, when its listeners can act. */
  protected onceConnected(report: () => void): void {
    if (this.state.name === "connected") report();
    else this.#postponed.push(report);
  }

  /** Is called for a new session, before its state is emitted: claims are restored here. */
  protected abstract sessionBegan(call: Call): Promise<void>;

  /** Is called when the session is gone; `closed`: for good; `code`: the close code, where there was one. */
  protected abstract sessionEnded(closed: boolean, code?: number): void;

  /** Is called when engines or components have changed; without a notice any may have. */
  protected abstract profileChanged(change: ProfileChange, notice?: DirectoryChangedNotification): void;

  async #handshake(session: JsonRpcSession): Promise<void> {
    const call: Call = (method, ...[params, late]) => ask(session, method, params, late);
    await call("rois.system.connect");
    try {
      const hello = { version: EXTENSION_VERSION, extensions: EXTENSIONS };
      this.#extensions = (await call("openrois.hello", hello)).extensions ?? [];
    } catch (error) {
      if (!(error instanceof RpcError && error.code === METHOD_NOT_FOUND)) throw error;
      this.#extensions = null;
    }
    await this.sessionBegan(call);
  }

  #stateChanged(state: ConnectionState): void {
    clearInterval(this.#probe);
    clearTimeout(this.#doubt);
    if (state.name === "connected") this.#probe = setInterval(() => this.#probeIdle(), this.#idleProbe / 4);
    else this.sessionEnded(state.name === "closed", state.name === "waiting" ? state.code : undefined);
    this.emitter.emit("state", state);
    if (state.name === "connected") for (const report of this.#postponed.splice(0)) report();
  }

  /** A browser cannot ping: only an unanswered request shows that a silent connection is dead. */
  #probeIdle(): void {
    if (this.#connection.silence >= this.#idleProbe)
      void this.call("rois.command.search").catch(() => undefined);
  }

  #notified(notification: Notification): void {
    const { method, params } = notification;
    const wrong = wrongInNotification(method, params);
    if (wrong !== null) return this.passedOver(`${method}: ${wrong}`);
    switch (method) {
      case "openrois.reason":
        this.#explained(params as unknown as ReasonNotification);
        break;
      case "rois.command.completed":
        this.#completed(params as unknown as Completed);
        break;
      case "rois.event.notify_event":
        this.emitter.emit("event", { expire: "", results: [], ...params } as unknown as RoISEvent);
        break;
      case "rois.system.notify_error":
        this.emitter.emit("fault", params as unknown as ErrorNotification);
        break;
      case "openrois.auth.expiring":
        this.#renew();
        break;
      case "openrois.events_dropped":
        this.emitter.emit("dropped", (params as unknown as EventsDroppedNotification).count);
        break;
      case "rois.system.profile_changed":
        this.#changed();
        break;
      case "openrois.directory.changed":
        this.#changed(params as unknown as DirectoryChangedNotification);
        break;
    }
    this.emitter.emit("notification", notification);
  }

  #changed(notice?: DirectoryChangedNotification): void {
    const { changed = [], gone = [], unnamed = 0 } = notice ?? {};
    const change: ProfileChange = { engineIds: new Set(unnamed > 0 ? [] : [...changed, ...gone]) };
    this.profileChanged(change, notice);
    this.emitter.emit("profile_changed", change);
  }

  /** The gateway ends the connection with its token: a newer one, if there is one, is shown on this connection. */
  #renew(): void {
    const token = this.#newest();
    if (token === undefined || token === this.#shown) return;
    this.#shown = token;
    void this.call("openrois.auth.refresh", { token }).catch(() => undefined);
  }

  /** Keeps a reason; it comes right before what it explains, so the last one is enough. */
  #explained(explanation: ReasonNotification): void {
    const reason = oneLine(explanation.reason);
    if (typeof explanation.request_id === "number") this.#connection.explain(explanation.request_id, reason);
    this.#reason = { ...explanation, reason };
  }

  #completed(completed: Completed): void {
    const explanation = this.#reason;
    this.#reason = null;
    const explained = explanation?.command_id === completed.command_id && completed.status !== "OK";
    this.emitter.emit("completed", explained ? { ...completed, reason: explanation.reason } : completed);
  }
}

/** Cleans a reason, which may be any text. */
function oneLine(text: string): string {
  return text
    .slice(0, 500)
    .replace(/[\s\p{C}]+/gu, " ")
    .trim();
}

async function ask<Method extends CallName>(
  asked: Pick<JsonRpcSession, "request">,
  method: Method,
  params: Params<Method> | undefined,
  late: Late<Method> | undefined,
): Promise<ResultOf<Method>> {
  const onLate = (result: Json): void => {
    try {
      late?.(accepted(method, params, result));
    } catch {
      // It was refused: there is nothing to undo.
    }
  };
  let reason = "";
  const onReason = (text: string): void => {
    reason = text;
  };
  const result = await asked.request(method, (params ?? {}) as JsonObject, late && onLate, onReason);
  return accepted(method, params, result, reason);
}

/** @throws RoISError when the return code is not OK | InvalidMessage when the result is not what the method gives */
function accepted<Method extends CallName>(
  method: Method,
  params: unknown,
  result: Json,
  reason = "",
): ResultOf<Method> {
  const wrong = wrongInResult(method, result);
  if (wrong !== null) throw new InvalidMessage(`${method}: ${wrong}`);
  const { return_code } = result as { readonly return_code: ReturnCode };
  if (return_code !== "OK") throw new RoISError(return_code, method, asked((params ?? {}) as Asked), reason);
  return result as ResultOf<Method>;
}

/** Members of params that errors name; unchecked, since the caller may be JavaScript. */
interface Asked {
  readonly component_ref?: unknown;
  readonly query_type?: unknown;
  readonly event_type?: unknown;
  readonly condition?: unknown;
  readonly command_type?: unknown;
  readonly command_unit_list?: unknown;
  readonly command_list?: Asked[];
}

/** Returns what was asked, for a person: `(start of robot/navigation)`. */
function asked(params: Asked): string {
  const sequence: Asked[] = Array.isArray(params.command_unit_list) ? params.command_unit_list : [];
  const parts = [params.component_ref, params.query_type, params.event_type, params.condition]
    .concat(
      sequence
        .flatMap((unit) => unit.command_list ?? unit)
        .map((unit) => `${unit.command_type} of ${unit.component_ref}`),
    )
    .filter(Boolean)
    .join(", ");
  return parts && `(${parts.slice(0, 200)})`;
}
