/** Brings one stream, verb by verb, into the desired state, with retries. */

import { METHOD_NOT_FOUND } from "../jsonrpc/peer.ts";
import { ConnectionLost, RpcError } from "../jsonrpc/session.ts";
import { Backoff } from "../rois/backoff.ts";
import type { BackoffOptions } from "../rois/backoff.ts";
import { RoISError } from "../rois/errors.ts";

export type Desire = "running" | "suspended" | "disconnected";
export type Verb = "connect" | "suspend" | "resume" | "disconnect";

export interface Problem {
  readonly kind:
    /** The gateway has no streaming: it speaks plain RoIS. */
    | "no-streaming"
    /** This browser and the engine have no codec in common, or the engine has no such component. */
    | "unsupported"
    /** The engine refused for another reason. */
    | "refused"
    /** The stream is connected, and nothing arrives. */
    | "no-media";
  /** The engine's reason, a sentence, where it gave one; else a return code. */
  readonly detail: string;
}

/** The streaming verbs, and callbacks for their outcome. */
export interface Verbs {
  /** Whether the engine can be reached now. */
  ready(): boolean;
  /** Returns the id of the new connection. */
  connect(): Promise<string>;
  perform(verb: Exclude<Verb, "connect">, streamId: string): Promise<void>;
  /** Is called when the stream is connected and has an id. */
  onConnected(): void;
  /** Is called when the stream is gone: disconnected (`wanted`), or unknown to the engine. */
  onReleased(wanted: boolean): void;
  onProblem(problem: Problem | null): void;
  onChange(): void;
}

/** Returns the next verb towards the desired state; null when it is reached. */
export function nextVerb(desire: Desire, connected: boolean, suspended: boolean): Verb | null {
  if (desire === "disconnected") return connected ? "disconnect" : null;
  if (!connected) return "connect";
  if (desire === "suspended") return suspended ? null : "suspend";
  return suspended ? "resume" : null;
}

/** Runs at most one verb of a stream at a time; after a failure the next attempt waits. */
export class Reconciler {
  readonly #verbs: Verbs;
  readonly #backoff: Backoff;
  #desire: Desire = "disconnected";
  #streamId: string | null = null;
  #suspended = false;
  #run: Promise<void> | null = null;
  #again = false;
  #retry: ReturnType<typeof setTimeout> | undefined;

  constructor(verbs: Verbs, backoff: BackoffOptions = {}) {
    this.#verbs = verbs;
    this.#backoff = new Backoff(backoff);
  }

  get desire(): Desire {
    return this.#desire;
  }

  get streamId(): string | null {
    return this.#streamId;
  }

  get busy(): boolean {
    return this.#run !== null;
  }

  /** Whether the desired state is not reached. */
  get pending(): boolean {
    return nextVerb(this.#desire, this.#streamId !== null, this.#suspended) !== null;
  }

  /** Returns once nothing is left to do, or what is left has to wait. */
  want(desire: Desire): Promise<void> {
    this.#desire = desire;
    this.#backoff.reset();
    return this.kick();
  }

  /** Tries at once. */
  kick(): Promise<void> {
    clearTimeout(this.#retry);
    if (this.#run) {
      this.#again = true;
      return this.#run;
    }
    this.#run = this.#reconcile().finally(() => {
      this.#run = null;
      this.#verbs.onChange();
    });
    this.#verbs.onChange();
    return this.#run;
  }

  /** Resets the backoff, since media flows. */
  succeeded(): void {
    this.#backoff.reset();
  }

  /** Notes that the engine has suspended the stream; `running` then needs `resume`. */
  suspendedByEngine(): void {
    this.#suspended = true;
  }

  /** Notes that the stream is no longer connected; returns whether it was. */
  lost(): boolean {
    if (this.#streamId === null) return false;
    this.#streamId = null;
    this.#suspended = false;
    this.#retryLater();
    return true;
  }

  async #reconcile(): Promise<void> {
    do {
      this.#again = false;
      const verb = nextVerb(this.#desire, this.#streamId !== null, this.#suspended);
      if (!verb || !this.#verbs.ready()) continue;
      try {
        await (verb === "connect" ? this.#connect() : this.#perform(verb));
        this.#again = true;
      } catch (error) {
        this.#failed(verb, error);
      }
    } while (this.#again);
  }

  async #connect(): Promise<void> {
    this.#streamId = await this.#verbs.connect();
    this.#suspended = false;
    this.#verbs.onProblem(null);
    this.#verbs.onConnected();
  }

  async #perform(verb: Exclude<Verb, "connect">): Promise<void> {
    const streamId = this.#streamId;
    if (streamId === null) return;
    if (verb === "disconnect") {
      // Whatever the answer, this side is done with the stream: its id must not be used again.
      this.#streamId = null;
      this.#suspended = false;
      this.#verbs.onProblem(null);
      this.#verbs.onReleased(true);
    }
    await this.#verbs.perform(verb, streamId);
    if (this.#streamId === streamId) this.#suspended = verb === "suspend";
  }

  #failed(verb: Verb, error: unknown): void {
    // A new connection to the gateway kicks every stream, and what was to be disconnected is gone with the old one.
    if (error instanceof ConnectionLost || verb === "disconnect") return;
    if (verb === "connect") this.#verbs.onProblem(describe(error));
    else if (error instanceof RoISError && error.returnCode === "UNSUPPORTED") {
      this.lost();
      return this.#verbs.onReleased(false);
    }
    this.#retryLater();
  }

  #retryLater(): void {
    clearTimeout(this.#retry);
    if (this.pending) this.#retry = setTimeout(() => void this.kick(), this.#backoff.next());
  }
}

function describe(error: unknown): Problem {
  if (error instanceof RpcError && error.code === METHOD_NOT_FOUND) {
    return { kind: "no-streaming", detail: "the gateway does not know rois.stream.connect_stream" };
  }
  if (error instanceof RoISError) {
    const kind = error.returnCode === "UNSUPPORTED" ? "unsupported" : "refused";
    return { kind, detail: error.reason || error.returnCode };
  }
  return { kind: "refused", detail: error instanceof Error ? error.message : String(error) };
}
