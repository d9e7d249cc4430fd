/** A stream of this machine's microphone or camera to a component. */

import type { BackoffOptions } from "../rois/backoff.ts";
import type { Purpose, StreamStatus } from "../rois/generated/types.ts";
import type { Capture, CaptureProblem } from "./capture.ts";
import type { Attachment } from "./place.ts";
import { ControlledStream } from "./stream.ts";
import type { EncodingLimits, StreamDescription, StreamOperations } from "./stream.ts";

/**
 * Like a stream that is received; `connect` also takes the device into use and `disconnect` lets go of it. A stream
 * that was lost is connected again with the same device: the user is asked by `connect` and `use` alone.
 */
export class LocalStream extends ControlledStream {
  readonly #capture: Capture;
  readonly #operations: StreamOperations;
  #visitorRef = "";
  /** Whether the engine has suspended it. */
  #muted = false;
  #held = false;

  constructor(
    what: StreamDescription,
    capture: Capture,
    operations: StreamOperations,
    backoff: BackoffOptions = {},
  ) {
    super(what, operations, backoff);
    this.#operations = operations;
    this.#capture = capture;
    this.place.onAttached = (attachment) => void this.#send(attachment);
    capture.onChange(() => this.#follow());
  }

  /** Whether silence or a black picture is sent instead; the stream itself stays. */
  get muted(): boolean {
    return this.#muted;
  }

  set muted(muted: boolean) {
    this.#muted = muted;
    this.#follow();
  }

  /** The captured track, for a preview and a level; null while the device is not in use. */
  get captured(): MediaStreamTrack | null {
    return this.#capture.track;
  }

  /** What is wrong with the device; `problem` is what is wrong with the stream. */
  get captureProblem(): CaptureProblem | null {
    return this.#capture.problem;
  }

  /** The device that is in use, or was last; null for the system's choice. */
  get deviceId(): string | null {
    return this.#capture.deviceId;
  }

  /** @internal */
  override get outgoing(): MediaStreamTrack | null {
    // The engine has to know what may be done with it.
    const mayBeSent = this.desire === "running" && !this.#held && this.told === this.stated;
    return mayBeSent ? this.#capture.track : null;
  }

  /** @internal */
  override get expectsMedia(): boolean {
    return super.expectsMedia && (this.outgoing !== null || this.direction === "sendrecv");
  }

  /** The visitor that this application is to others, once it has said anew what it consents to; empty before. */
  get visitorRef(): string {
    return this.#visitorRef;
  }

  /** All that it may be used for, as it was said last; null where nothing is said. */
  get consent(): readonly Purpose[] | null {
    return this.stated;
  }

  /**
   * Consents to these purposes, and to no other, from now on; it holds for all that this application sends to the body,
   * so tell its other streams as well. Without any everything is withdrawn. Nothing is sent until the body knows it.
   *
   * @throws RoISError when the body refuses; what was said holds from the next connection on all the same
   */
  async setConsent(consent: readonly Purpose[]): Promise<void> {
    const stated = (this.stated = [...consent]);
    this.#follow();
    if (this.streamId !== null) {
      this.#visitorRef = await this.#operations.setConsent(this.streamId, stated);
      this.told = stated;
      this.#follow();
    }
  }

  /** The devices that could be used; before the user's consent browsers hide their names. */
  devices(): Promise<MediaDeviceInfo[]> {
    return this.#capture.list();
  }

  /** Changes to another device; on failure the present one stays in use, and `captureProblem` says why. */
  async use(deviceId: string): Promise<void> {
    await this.#capture.open(deviceId);
  }

  /** Asks for the device, then connects. Without a device nothing is connected. */
  override async connect(): Promise<void> {
    if (await this.#capture.open()) await super.connect();
  }

  /** Stops capturing and sending at once, without waiting for the engine; the connection stays. */
  override suspend(): Promise<void> {
    const done = super.suspend();
    this.#follow();
    return done;
  }

  override resume(): Promise<void> {
    this.#held = false;
    const done = super.resume();
    this.#follow();
    return done;
  }

  override disconnect(): Promise<void> {
    const done = super.disconnect();
    this.#capture.close();
    return done;
  }

  /** Takes a status; an engine that resumes a stream which it suspended reports another status. @internal */
  override reported(status: StreamStatus): void {
    this.#held = status === "STREAMING_SUSPENDED" && this.desire === "running";
    super.reported(status);
    this.#follow();
  }

  /** @internal */
  override lost(status: StreamStatus | null): void {
    this.#held = false;
    super.lost(status);
  }

  #follow(): void {
    const { track } = this.#capture;
    if (track) track.enabled = this.desire !== "suspended" && !this.#muted;
    for (const attachment of [this.place.current, this.place.next]) {
      if (attachment) void this.#send(attachment);
    }
    this.changed();
  }

  async #send({ peer, transceiver: { sender } }: Attachment): Promise<void> {
    try {
      if (sender.track !== this.outgoing) await sender.replaceTrack(this.outgoing);
      await limit(sender, this.limits);
    } catch (error) {
      if (!peer.closed) console.warn("openrois: what is sent could not be changed", error);
    }
  }
}

async function limit(sender: RTCRtpSender, { max_bitrate, fps }: EncodingLimits): Promise<void> {
  if (max_bitrate === undefined && fps === undefined) return;
  const parameters = sender.getParameters();
  const [encoding] = parameters.encodings;
  // Before the first answer there is nothing to be limited, and what was set stays set.
  if (!encoding || (encoding.maxBitrate === max_bitrate && encoding.maxFramerate === fps)) return;
  if (max_bitrate !== undefined) encoding.maxBitrate = max_bitrate;
  if (fps !== undefined) encoding.maxFramerate = fps;
  await sender.setParameters(parameters);
}
