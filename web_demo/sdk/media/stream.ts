/** One stream that this application receives. */

import { Emitter } from "../events.ts";
import type { BackoffOptions } from "../rois/backoff.ts";
import type { MediaKind, StreamStatus } from "../rois/generated/types.ts";
import type { MediaPeer } from "./peer.ts";
import { Reconciler } from "./reconciler.ts";
import type { Desire, Problem, Verb } from "./reconciler.ts";
import { figuresBetween } from "./statistics.ts";
import type { Figures, Sample } from "./statistics.ts";

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

/** Where a stream arrives: a receiver of one of the peer connections. */
export interface Attachment {
  readonly peer: MediaPeer;
  readonly receiver: RTCRtpReceiver;
}

/** What a stream needs of the `MediaReceiver` to which it belongs. */
export interface StreamOperations {
  /** The gateway can be asked now. */
  ready(): boolean;
  connect(componentRef: string, kind: MediaKind): Promise<string>;
  perform(verb: Exclude<Verb, "connect">, streamId: string): Promise<void>;
  /** The stream has another id, or none: see where it arrives. */
  relocate(stream: RemoteStream): void;
}

/**
 * Keeps one stream in the wanted state. What was lost is connected again; a suspended stream comes back suspended, a
 * disconnected one stays away.
 *
 * The verbs return once the engine has agreed or refused. They do not throw: what is wrong stands in `problem`, and
 * is tried again.
 */
export class RemoteStream {
  readonly componentRef: string;
  readonly kind: MediaKind;
  /** For the `MediaReceiver` that owns the stream. @internal */
  readonly arrival: StreamArrival;
  readonly #events = new Emitter<StreamEvents>();
  readonly #reconciler: Reconciler;
  #status: StreamStatus | null = "STREAMING_NOT_CONNECTED";
  #problem: Problem | null = null;
  #connectedAt = 0;

  constructor(
    componentRef: string,
    kind: MediaKind,
    operations: StreamOperations,
    backoff: BackoffOptions = {},
  ) {
    this.componentRef = componentRef;
    this.kind = kind;
    this.arrival = new StreamArrival(this.#events);
    this.arrival.onFlow = () => {
      this.#reconciler.succeeded();
      if (this.#problem?.kind === "no-media") this.fail(null);
    };
    this.#reconciler = new Reconciler(
      {
        ready: () => operations.ready(),
        connect: () => operations.connect(componentRef, kind),
        perform: (verb, streamId) => operations.perform(verb, streamId),
        onConnected: () => {
          this.#connectedAt = performance.now();
          this.#status = "STREAMING_NOT_RUNNING";
          operations.relocate(this);
        },
        onReleased: (wanted) => {
          this.#status = "STREAMING_NOT_CONNECTED";
          if (wanted) this.arrival.drop();
          operations.relocate(this);
        },
        onProblem: (problem) => this.fail(problem),
        onChange: () => this.#changed(),
      },
      backoff,
    );
  }

  /** The engine's id for this connection of the stream; null while there is none. */
  get streamId(): string | null {
    return this.#reconciler.streamId;
  }

  /** As RoIS reported it last; null while there is no connection to the gateway, so that nobody can know. */
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

  /** The track that carries the stream; null while none does. */
  get track(): MediaStreamTrack | null {
    return this.arrival.current?.receiver.track ?? null;
  }

  on<Name extends keyof StreamEvents>(name: Name, listener: (value: StreamEvents[Name]) => void): () => void {
    return this.#events.on(name, listener);
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
   * Media should be arriving now: the stream is connected, wanted, and runs or is about to for the first time. An
   * engine whose source has stopped says NOT_RUNNING, and nothing is wrong with the path. @internal
   */
  get expectsMedia(): boolean {
    if (this.streamId === null || this.desire !== "running") return false;
    if (this.#status === "STREAMING_RUNNING") return true;
    return this.#status === "STREAMING_NOT_RUNNING" && !this.arrival.flowed;
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
    this.#changed();
  }

  /** The stream is no longer connected; null says that nobody knows. @internal */
  lost(status: StreamStatus | null): void {
    this.#status = status;
    if (this.#reconciler.lost()) this.arrival.forget();
    this.#changed();
  }

  /** @internal */
  fail(problem: Problem | null): void {
    this.#problem = problem;
    this.#changed();
  }

  #changed(): void {
    this.#events.emit("change", undefined);
  }
}

/** Where a stream arrives now, and where it will once the first frame has come there. */
export class StreamArrival {
  onFlow: () => void = () => undefined;
  readonly #events: Emitter<StreamEvents>;
  #current: Attachment | null = null;
  #next: Attachment | null = null;
  #sample: Sample | null = null;
  #located = false;

  constructor(events: Emitter<StreamEvents>) {
    this.#events = events;
  }

  get current(): Attachment | null {
    return this.#current;
  }

  get next(): Attachment | null {
    return this.#next;
  }

  get newest(): Attachment | null {
    return this.#next ?? this.#current;
  }

  /** The present connection of the stream has a place; what is shown may still come from the one before. */
  get located(): boolean {
    return this.#located;
  }

  /** Something has arrived at the newest place. */
  get flowed(): boolean {
    return this.#located && this.#next === null && this.#sample !== null && this.#sample.units > 0;
  }

  /** The stream arrives here too. It is shown from here at once if it was shown nowhere. */
  attach(attachment: Attachment): void {
    const { newest } = this;
    this.#located = true;
    if (newest?.peer === attachment.peer && newest.receiver === attachment.receiver) return;
    this.#next = attachment;
    if (!this.#current) this.promote();
  }

  /** The first frame has come: the stream is shown from the newest place. */
  promote(): void {
    if (!this.#next) return;
    this.#current = this.#next;
    this.#next = null;
    this.#sample = null;
    this.#events.emit("track", this.#current.receiver.track);
    this.#events.emit("change", undefined);
  }

  /** A peer connection is about to be closed. */
  detach(peer: MediaPeer): void {
    if (this.#next?.peer === peer) this.#next = null;
    if (this.#current?.peer === peer) this.#interrupt();
    this.promote();
  }

  /** The connection of the stream has ended. What is shown stays. */
  forget(): void {
    this.#next = null;
    this.#located = false;
  }

  /** The stream is not wanted any more. */
  drop(): void {
    this.forget();
    if (this.#current) this.#interrupt();
  }

  /** Counters of the current place. */
  sampled(sample: Sample): void {
    const figures = this.#sample && figuresBetween(this.#sample, sample);
    this.#sample = sample;
    if (!figures) return;
    if (figures.rate > 0) this.onFlow();
    this.#events.emit("figures", figures);
  }

  #interrupt(): void {
    this.#events.emit("interrupted", undefined);
    this.#current = null;
    this.#sample = null;
    this.#events.emit("change", undefined);
  }
}
