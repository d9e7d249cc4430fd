/** One stream of this application: what it is wanted to be, and what it is. */

import { Emitter } from "../jsonrpc/events.ts";
import type { BackoffOptions } from "../rois/backoff.ts";
import type { Direction, MediaKind, Purpose, StreamStatus } from "../rois/generated/types.ts";
import { captureTime } from "./engine_clock.ts";
import { Hush } from "./hush.ts";
import { StreamPlace } from "./place.ts";
import { Reconciler } from "./reconciler.ts";
import type { Desire, Problem, Verb } from "./reconciler.ts";
import type { Figures } from "./statistics.ts";

/** Limits of the encoder, at the other end or at this one; it may stay below them. */
export interface EncodingLimits {
  readonly width?: number;
  readonly height?: number;
  /** Frames per second. */
  readonly fps?: number;
  /** Bits per second. */
  readonly max_bitrate?: number;
  /** Of sound that is sent: 2 for what two microphones hear, if the device has them and its echo cancellation is off. */
  readonly channels?: number;
}

export interface StreamEvents {
  /** Any of the properties has changed. */
  change: undefined;
  /** Another track carries the stream from now on. */
  track: MediaStreamTrack;
  /** The track is about to end; what it shows now is the last picture. */
  interrupted: undefined;
  /** Once a second while there is a track. */
  figures: Figures;
}

/** What a stream needs of the `MediaReceiver` to which it belongs. */
export interface StreamOperations {
  /** The gateway can be asked now. */
  ready(): boolean;
  connect(stream: ControlledStream): Promise<string>;
  perform(verb: Exclude<Verb, "connect">, streamId: string): Promise<void>;
  /** Returns the visitor that this application is. */
  setConsent(streamId: string, consent: readonly Purpose[]): Promise<string>;
  /** The stream has another id, or none: see where it is carried. */
  relocate(stream: ControlledStream): void;
}

export interface StreamDescription {
  readonly componentRef: string;
  readonly kind: MediaKind;
  /** Which way the media goes, as this application sees it; `sendrecv` is for sound only. */
  readonly direction: Direction;
  readonly limits: EncodingLimits;
  /** What its sender consents to; null where nothing is said. */
  readonly consent?: readonly Purpose[] | null;
}

/**
 * Keeps one stream in the wanted state. What was lost is connected again; a suspended stream comes back suspended, a
 * disconnected one stays away.
 *
 * The verbs return once the engine has agreed or refused. They do not throw: what is wrong stands in `problem`, and
 * is tried again.
 */
export abstract class ControlledStream {
  readonly componentRef: string;
  readonly kind: MediaKind;
  readonly direction: Direction;
  readonly limits: EncodingLimits;
  /** What is consented to when it is connected next; null where nothing is said. @internal */
  stated: readonly Purpose[] | null;
  /** What of it the engine knows; undefined before the first connection. @internal */
  told: readonly Purpose[] | null | undefined;
  /** For the `MediaReceiver` that owns the stream. @internal */
  readonly place: StreamPlace;
  readonly #events = new Emitter<StreamEvents>();
  readonly #reconciler: Reconciler;
  #status: StreamStatus | null = "STREAMING_NOT_CONNECTED";
  #problem: Problem | null = null;
  #connectedAt = 0;

  constructor(what: StreamDescription, operations: StreamOperations, backoff: BackoffOptions = {}) {
    this.componentRef = what.componentRef;
    this.kind = what.kind;
    this.direction = what.direction;
    this.limits = what.limits;
    this.stated = what.consent ?? null;
    this.place = new StreamPlace(this.#events, what.direction !== "sendonly");
    this.place.onFlow = () => {
      this.#reconciler.succeeded();
      if (this.#problem?.kind === "no-media") this.fail(null);
    };
    this.#reconciler = new Reconciler(
      {
        ready: () => operations.ready(),
        connect: () => operations.connect(this),
        perform: (verb, streamId) => operations.perform(verb, streamId),
        onConnected: () => {
          this.#connectedAt = performance.now();
          this.#status = "STREAMING_NOT_RUNNING";
          operations.relocate(this);
        },
        onReleased: (wanted) => {
          this.#status = "STREAMING_NOT_CONNECTED";
          if (wanted) this.place.drop();
          operations.relocate(this);
        },
        onProblem: (problem) => this.fail(problem),
        onChange: () => this.changed(),
      },
      backoff,
    );
  }

  /** The engine's id for this connection of the stream; null while there is none. */
  get streamId(): string | null {
    return this.#reconciler.streamId;
  }

  /** Newest status reported by RoIS; null without a connection to the gateway. */
  get status(): StreamStatus | null {
    return this.#status;
  }

  /** What the user of the stream wants it to be. */
  get desire(): Desire {
    return this.#reconciler.desire;
  }

  get problem(): Problem | null {
    return this.#problem;
  }

  /** A verb is under way. */
  get busy(): boolean {
    return this.#reconciler.busy;
  }

  /** The track that arrives; null while none does, and for a stream that is only sent. */
  get track(): MediaStreamTrack | null {
    return this.direction === "sendonly" ? null : (this.place.current?.transceiver.receiver.track ?? null);
  }

  on<Name extends keyof StreamEvents>(name: Name, listener: (value: StreamEvents[Name]) => void): () => void {
    return this.#events.on(name, listener);
  }

  /** What is sent now; null for nothing, and in a stream that is only received. @internal */
  get outgoing(): MediaStreamTrack | null {
    return null;
  }

  /** Connects the stream, and again whenever it is lost. */
  connect(): Promise<void> {
    return this.#reconciler.want(this.desire === "disconnected" ? "running" : this.desire);
  }

  /** Stops the flow and keeps the connection; the last picture stays. */
  suspend(): Promise<void> {
    return this.#reconciler.want("suspended");
  }

  resume(): Promise<void> {
    if (this.#status === "STREAMING_SUSPENDED") this.#reconciler.suspendedByEngine();
    return this.#reconciler.want("running");
  }

  disconnect(): Promise<void> {
    return this.#reconciler.want("disconnected");
  }

  /**
   * Media should be flowing now: the stream is connected, wanted, and runs or is about to for the first time. An
   * engine whose source has stopped says NOT_RUNNING, and nothing is wrong with the path. @internal
   */
  get expectsMedia(): boolean {
    if (this.streamId === null || this.desire !== "running") return false;
    if (this.#status === "STREAMING_RUNNING") return true;
    return this.#status === "STREAMING_NOT_RUNNING" && !this.place.flowed;
  }

  /** Since when the stream is connected, on the clock of `performance.now`. @internal */
  get connectedAt(): number {
    return this.#connectedAt;
  }

  /** There is a reason to try at once what has failed. */
  retryNow(): void {
    void this.#reconciler.kick();
  }

  /** The engine reported the stream's status. @internal */
  reported(status: StreamStatus): void {
    if (status === "STREAMING_NOT_CONNECTED") return this.lost(status);
    // RESUMED is an event; the state that follows it is RUNNING.
    this.#status = status === "STREAMING_RESUMED" ? "STREAMING_RUNNING" : status;
    // A stream that could not be suspended before it ran can be now.
    if (this.#reconciler.pending) void this.#reconciler.kick();
    this.changed();
  }

  /** Notes that the stream is no longer connected; null for an unknown status. @internal */
  lost(status: StreamStatus | null): void {
    this.#status = status;
    if (this.#reconciler.lost()) this.place.connectionEnded();
    this.changed();
  }

  /** @internal */
  fail(problem: Problem | null): void {
    this.#problem = problem;
    this.changed();
  }

  /** A property has changed. */
  protected changed(): void {
    this.#events.emit("change", undefined);
  }
}

/** A stream that this application receives. */
export class RemoteStream extends ControlledStream {
  readonly #hush = new Hush();

  /** Milliseconds from the arrival of its media to their being played, lately; null while nothing plays. */
  get playoutDelay(): number | null {
    return this.place.playoutDelay;
  }

  /**
   * When a picture or a block of sound that arrives now was captured, in milliseconds since the epoch on the engine's
   * clock; null while the engine has not said so.
   *
   * @param rtpTimestamp of a frame, as `requestVideoFrameCallback` and `getSynchronizationSources` give it
   */
  capturedAt(rtpTimestamp: number): number | null {
    const { current } = this.place;
    const clock = current?.peer.clocks.find(({ mid }) => mid === current.transceiver.mid);
    return clock ? captureTime(clock, rtpTimestamp) : null;
  }

  /**
   * Silences what is still buffered here of a sound that the avatar is made to break off: at once, and until it has run
   * out. Call it together with `stop`; the sound ends then, and not with the buffer, which may hold 350 ms.
   *
   * @param cut resolves when the avatar has broken it off, as `stop` does or the event that says so; without it the
   *   avatar has done so already
   * @returns resolves when the stream is heard again
   */
  async hush(cut: Promise<unknown> = Promise.resolve()): Promise<void> {
    if (this.track) await this.#hush.begin(this.track, () => this.playoutDelay, cut);
  }
}
