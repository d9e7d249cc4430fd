/** The streams of one application, both ways: streaming verbs, signaling, peer connections, recovery. */

import type { Notification } from "../jsonrpc/peer.ts";
import type { BackoffOptions } from "../rois/backoff.ts";
import type { ConnectionState } from "../rois/connection.ts";
import { engineOf } from "../rois/discovery.ts";
import { RoISError } from "../rois/errors.ts";
import type {
  Bye,
  CaptureClocks,
  DirectoryChangedNotification,
  MediaKind,
  Offer,
  StreamStatusNotification,
} from "../rois/generated/types.ts";
import type { InputChannels } from "../input/channels.ts";
import { Capture } from "./capture.ts";
import { decodableCodecs, encodableCodecs } from "./codecs.ts";
import { IceServers } from "./ice_servers.ts";
import { LocalStream } from "./local_stream.ts";
import { Negotiation } from "./negotiation.ts";
import type { CandidateMessage, Effect } from "./negotiation.ts";
import { FIRST_FRAME_WITHIN, PathWatch } from "./path_watch.ts";
import { sizeWanted, streamParameters } from "./parameters.ts";
import { MediaPeer } from "./peer.ts";
import { PlayoutReports } from "./playout_reports.ts";
import { progress, readCounters } from "./place.ts";
import type { MediaLink, ReceiverOptions, SendingOptions } from "./receiver_options.ts";
import type { Problem, Verb } from "./reconciler.ts";
import type { Sample } from "./statistics.ts";
import { RemoteStream } from "./stream.ts";
import type { ControlledStream, EncodingLimits, StreamOperations } from "./stream.ts";

/** Backoff of streams. An engine that returns changes the profile, which causes an attempt at once. */
const BACKOFF: BackoffOptions = { first: 1000, factor: 2, max: 15_000 };

/** Milliseconds after which a connected stream without an offer is given up; the engine should do so after 15 s. */
const OFFER_WITHIN = 20_000;

/** Milliseconds between two readings of the counters, usually and while a first frame is awaited. */
const TICK = 1000;
const QUICK_TICK = 100;

interface OpenPeer {
  readonly peer: MediaPeer;
  readonly watch: PathWatch;
  /** Its session has ended, or another peer replaces it: nothing new is negotiated on it. */
  leaving: boolean;
}

/**
 * All streams of one engine share a peer connection. A new one (after a restart, or a new session) is opened beside
 * the old one, each stream moves over when its first frame is there, and the old one is closed when it is empty.
 */
export class MediaReceiver {
  readonly #link: MediaLink;
  readonly #options: ReceiverOptions;
  readonly #iceServers: IceServers;
  readonly #negotiation = new Negotiation();
  readonly #streams = new Map<string, ControlledStream>();
  readonly #peers = new Map<string, OpenPeer>();
  readonly #stopListening: (() => void)[];
  #timer: ReturnType<typeof setTimeout> | undefined;
  #closed = false;

  constructor(link: MediaLink, options: ReceiverOptions = {}) {
    this.#link = link;
    this.#options = options;
    this.#iceServers = new IceServers(link);
    this.#stopListening = [
      link.on("state", (state) => this.#stateChanged(state)),
      link.on("notification", (notification) => this.#notified(notification)),
    ];
    this.#scheduleTick();
  }

  /**
   * Returns the stream that comes from a component; it is not connected before its `connect` is called.
   *
   * @param limits more than this is not to be sent; those of the first call hold
   */
  stream(componentRef: string, kind: MediaKind, limits: EncodingLimits = {}): RemoteStream {
    return this.#known(`from ${componentRef}`, (backoff) => {
      const what = { componentRef, kind, direction: "recvonly", limits } as const;
      return new RemoteStream(what, this.#operations(), backoff);
    });
  }

  /**
   * Returns the stream of this machine's microphone or camera to a component. Its `connect` asks the user for the
   * device: call it when the user wants it, and not before.
   */
  sending(componentRef: string, kind: MediaKind, options: SendingOptions = {}): LocalStream {
    const { direction = "sendonly", limits = {}, consent = null, constraints } = options;
    return this.#known(`to ${componentRef}`, (backoff) => {
      const capture = new Capture(kind, { ...sizeWanted(limits), ...constraints }, this.#options.devices);
      const what = { componentRef, kind, direction, limits, consent };
      return new LocalStream(what, capture, this.#operations(), backoff);
    });
  }

  /**
   * Asks the engine for new peer connections at once, since the network may have changed, before the old ones have
   * failed. The picture stays until a new one plays.
   */
  networkChanged(): void {
    for (const { peer, leaving } of this.#peers.values()) if (!leaving) void this.#restart(peer.peerId);
  }

  /** The data channels to an engine that are open, the newest first; none without the option `input`. */
  inputs(engineId: string): InputChannels[] {
    const peers = [...this.#peers.values()].map(({ peer }) => peer);
    const own = peers.filter(({ peerId, input }) => engineOf(peerId) === engineId && input?.open);
    return own.flatMap(({ input }) => input ?? []).reverse();
  }

  /** Ends every stream and every peer connection. */
  async close(): Promise<void> {
    this.#closed = true;
    clearTimeout(this.#timer);
    await Promise.all([...this.#streams.values()].map((stream) => stream.disconnect()));
    for (const stop of this.#stopListening) stop();
    this.#negotiation.abandon();
    for (const { peer } of [...this.#peers.values()]) this.#closePeer(peer);
  }

  #known<Kind extends ControlledStream>(name: string, make: (backoff: BackoffOptions) => Kind): Kind {
    const known = this.#streams.get(name) as Kind | undefined;
    if (known) return known;
    const stream = make({ ...BACKOFF, ...this.#options.backoff });
    this.#streams.set(name, stream);
    if (stream.kind === "audio" && stream.direction !== "sendonly") this.#reportPlayout(stream);
    return stream;
  }

  #reportPlayout(stream: ControlledStream): void {
    const reports = new PlayoutReports((method, ...params) => this.#link.call(method, ...params));
    stream.on("figures", () => {
      const { streamId, place } = stream;
      reports.observeDelay({ streamId, delay: place.playoutDelay }, performance.now());
    });
  }

  #operations(): StreamOperations {
    return {
      ready: () => this.#link.state.name === "connected",
      connect: (stream) => this.#connect(stream),
      perform: (verb, streamId) => this.#perform(verb, streamId),
      setConsent: async (streamId, consent) => {
        const params = { stream_id: streamId, consent: [...consent] };
        return (await this.#link.call("rois.stream.set_consent", params)).visitor_ref ?? "";
      },
      relocate: (stream) => this.#relocate(stream),
    };
  }

  async #connect(stream: ControlledStream): Promise<string> {
    const { componentRef, kind, direction, limits } = stream;
    const usable = direction === "recvonly" ? decodableCodecs : encodableCodecs;
    const codecs = (this.#options.codecs ?? usable)(kind);
    await this.#iceServers.refresh();
    let { stated } = stream;
    const params = {
      component_ref: componentRef,
      parameters: streamParameters(codecs, limits, direction, this.#options.input, stated),
    };
    const disconnect = ({ stream_id = "" }): void =>
      mayFail(this.#link.call("rois.stream.disconnect_stream", { stream_id }));
    const connected = await this.#link.call("rois.stream.connect_stream", params, disconnect);
    const { stream_id: streamId = "" } = connected;
    try {
      // Consent was stated anew while the engine was asked with what was stated before.
      while (stream.stated !== stated) {
        ({ stated } = stream);
        await this.#operations().setConsent(streamId, stated ?? []);
      }
    } catch (error) {
      disconnect(connected);
      throw error;
    }
    stream.told = stated;
    return streamId;
  }

  async #perform(verb: Exclude<Verb, "connect">, streamId: string): Promise<void> {
    await this.#link.call(`rois.stream.${verb}_stream`, { stream_id: streamId });
  }

  /** Attaches a stream to the newest peer that carries it, and closes unused peers. */
  #relocate(stream: ControlledStream): void {
    const { streamId } = stream;
    if (streamId !== null) {
      const carriers = [...this.#peers.values()].map(({ peer }) => ({
        peer,
        transceiver: peer.section(streamId),
      }));
      const newest = carriers.findLast(({ transceiver }) => transceiver !== undefined);
      if (newest?.transceiver) stream.place.attach({ peer: newest.peer, transceiver: newest.transceiver });
    }
    this.#closeEmptyPeers();
    this.#scheduleTick();
  }

  #stateChanged(state: ConnectionState): void {
    if (state.name === "connected") {
      for (const stream of this.#streams.values()) stream.retryNow();
      return;
    }
    // The media may go on without the control link: the engine waits a while for its application to come back.
    this.#negotiation.abandon();
    this.#iceServers.expire();
    for (const open of this.#peers.values()) open.leaving = true;
    for (const stream of this.#streams.values()) stream.lost(null);
  }

  #notified({ method, params }: Notification): void {
    switch (method) {
      case "signaling.offer":
        return this.#runEffects(this.#negotiation.offer(params as unknown as Offer));
      case "signaling.candidate": {
        const missing = { sdp_mid: null, sdp_m_line_index: null };
        return this.#runEffects(
          this.#negotiation.candidate({ ...missing, ...params } as unknown as CandidateMessage),
        );
      }
      case "signaling.capture_clocks": {
        const { peer_id: peerId, senders } = params as unknown as CaptureClocks;
        const open = this.#peers.get(peerId);
        if (open) open.peer.clocks = senders;
        return;
      }
      case "signaling.bye": {
        const { peer_id: peerId, reason } = params as unknown as Bye;
        return this.#runEffects(this.#negotiation.endPeer(peerId, reason));
      }
      case "rois.stream.notify_stream_status": {
        const { stream_id: streamId, status } = params as unknown as StreamStatusNotification;
        this.#byId(streamId)?.reported(status);
        return this.#closeEmptyPeers();
      }
      case "rois.system.profile_changed":
        return this.#retryMissing(() => true);
      case "openrois.directory.changed": {
        const { changed = [], unnamed = 0 } = params as unknown as DirectoryChangedNotification;
        return this.#retryMissing((engineId) => unnamed > 0 || changed.includes(engineId));
      }
    }
  }

  /** Connects what could not be connected: its engine may be back. */
  #retryMissing(mayBeBack: (engineId: string) => boolean): void {
    for (const stream of this.#streams.values())
      if (stream.streamId === null && mayBeBack(engineOf(stream.componentRef))) stream.retryNow();
  }

  #byId(streamId: string): ControlledStream | undefined {
    return [...this.#streams.values()].find((each) => each.streamId === streamId);
  }

  #runEffects(effects: readonly Effect[]): void {
    for (const effect of effects) {
      switch (effect.kind) {
        case "open":
          this.#openPeer(effect.peerId, effect.replaces);
          break;
        case "apply":
          void this.#apply(effect.offer);
          break;
        case "send_answer":
          mayFail(
            this.#link.call("signaling.answer", {
              peer_id: effect.peerId,
              generation: effect.generation,
              sdp: effect.sdp,
            }),
          );
          break;
        case "send_candidate":
          mayFail(this.#link.call("signaling.candidate", effect.message));
          break;
        case "add_candidate":
          void this.#peers.get(effect.peerId)?.peer.addCandidate(effect.candidate);
          break;
        case "close":
          this.#peerEnded(effect.peerId);
      }
    }
  }

  #openPeer(peerId: string, replaces: string | null): void {
    const create =
      this.#options.createPeerConnection ?? ((configuration) => new RTCPeerConnection(configuration));
    const connection = create({ iceServers: this.#iceServers.current, bundlePolicy: "max-bundle" });
    const peer = new MediaPeer(peerId, connection, {
      onCandidate: (candidate) => this.#runEffects(this.#negotiation.gathered(peerId, candidate)),
      onStateChange: () => void this.#tick(),
    });
    this.#peers.set(peerId, { peer, watch: new PathWatch(), leaving: false });
    const old = replaces === null ? undefined : this.#peers.get(replaces);
    if (old) old.leaving = true;
  }

  async #apply(offer: Offer): Promise<void> {
    const open = this.#peers.get(offer.peer_id);
    if (!open) return;
    try {
      const sdp = await open.peer.apply(offer, (streamId) => this.#byId(streamId)?.outgoing ?? null);
      this.#runEffects(this.#negotiation.answered(offer.peer_id, offer.generation, sdp));
    } catch (error) {
      if (open.peer.closed) return;
      // Half an answer can't be taken back: the engine ends a peer that is not answered, this side does so now.
      console.error("openrois: the browser refused an offer", error);
      return this.#runEffects(this.#negotiation.endPeer(offer.peer_id, "the browser refused the offer"));
    }
    for (const stream of this.#streams.values()) this.#relocate(stream);
  }

  /** Closes a peer that has ended; streams that it alone carried are lost. */
  #peerEnded(peerId: string): void {
    const open = this.#peers.get(peerId);
    if (!open) return;
    this.#closePeer(open.peer);
    for (const stream of this.#streams.values()) {
      if (stream.streamId === null || !open.peer.streamIds.includes(stream.streamId)) continue;
      const elsewhere = [...this.#peers.values()].some(
        ({ peer, leaving }) => !leaving && peer.section(stream.streamId ?? "") !== undefined,
      );
      if (!elsewhere) stream.lost("STREAMING_NOT_CONNECTED");
    }
  }

  #closePeer(peer: MediaPeer): void {
    this.#peers.delete(peer.peerId);
    for (const stream of this.#streams.values()) stream.place.detach(peer);
    peer.close();
  }

  #closeEmptyPeers(): void {
    const streams = [...this.#streams.values()];
    for (const { peer, leaving } of [...this.#peers.values()]) {
      const used = streams.some(({ place }) => place.current?.peer === peer || place.next?.peer === peer);
      if (!leaving || used) continue;
      this.#negotiation.endPeer(peer.peerId, "replaced");
      this.#closePeer(peer);
    }
  }

  #scheduleTick(): void {
    clearTimeout(this.#timer);
    if (this.#closed) return;
    const quick = [...this.#streams.values()].some((stream) => stream.place.next !== null);
    this.#timer = setTimeout(() => void this.#tick(), quick ? QUICK_TICK : TICK);
  }

  async #tick(): Promise<void> {
    clearTimeout(this.#timer);
    const samples = new Map<ControlledStream, Sample>();
    await Promise.all(
      [...this.#streams.values()].map(async (stream) => {
        const sample = await this.#sampleStream(stream);
        if (sample) samples.set(stream, sample);
      }),
    );
    for (const stream of this.#streams.values()) this.#missOffer(stream);
    for (const open of [...this.#peers.values()]) this.#judge(open, samples);
    this.#closeEmptyPeers();
    this.#scheduleTick();
  }

  /** Reads the counters of a stream, and promotes its next section when media flows there. */
  async #sampleStream(stream: ControlledStream): Promise<Sample | null> {
    const { current, next } = stream.place;
    const [shown, coming] = await Promise.all([readCounters(current, stream), readCounters(next, stream)]);
    if (shown && stream.place.current === current) stream.place.sampled(shown);
    if (!next || stream.place.next !== next) return shown;
    const idle = !stream.expectsMedia && next.peer.connection.connectionState === "connected";
    if (idle || (coming && coming.units > 0)) stream.place.promote();
    return coming;
  }

  /** Reports a missing offer as a problem, and disconnects the stream when the engine does not. */
  #missOffer(stream: ControlledStream): void {
    const { streamId } = stream;
    if (streamId === null || !stream.expectsMedia || stream.place.located) return;
    const waited = performance.now() - stream.connectedAt;
    if (waited >= FIRST_FRAME_WITHIN && !stream.problem) {
      stream.fail({ kind: "no-media", detail: "the engine made no offer" });
    }
    if (waited < OFFER_WITHIN) return;
    mayFail(this.#link.call("rois.stream.disconnect_stream", { stream_id: streamId }));
    stream.lost("STREAMING_NOT_CONNECTED");
  }

  #judge(open: OpenPeer, samples: ReadonlyMap<ControlledStream, Sample>): void {
    const carried = [...this.#streams.values()].filter(
      ({ place }) => place.located && place.newest?.peer === open.peer,
    );
    const flows = carried.map((stream) => ({
      streamId: stream.streamId ?? "",
      expected: stream.expectsMedia,
      count: progress(samples.get(stream)),
    }));
    const { connectionState } = open.peer.connection;
    if (open.leaving) {
      if (connectionState === "failed" || connectionState === "closed") this.#closePeer(open.peer);
      return;
    }
    if (open.watch.observe(performance.now(), connectionState, flows) !== "restart") return;
    const problem: Problem = { kind: "no-media", detail: `ICE ${open.peer.connection.iceConnectionState}` };
    for (const stream of carried) if (stream.expectsMedia) stream.fail(problem);
    void this.#restart(open.peer.peerId);
  }

  async #restart(peerId: string): Promise<void> {
    try {
      await this.#iceServers.refresh();
      await this.#link.call("signaling.restart", { peer_id: peerId });
    } catch (error) {
      // The engine does not know the peer any more: only a new connection of its streams can help.
      if (error instanceof RoISError && error.returnCode !== "OUT_OF_RESOURCES") {
        this.#runEffects(this.#negotiation.endPeer(peerId, error.returnCode));
      }
    }
  }
}

/** Ignores a failed call: a lost answer or candidate leads to a peer that does not connect, which is detected. */
function mayFail(asked: Promise<unknown>): void {
  void asked.catch(() => undefined);
}
