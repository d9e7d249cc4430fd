/** Receives the streams of one application: streaming verbs, signaling, peer connections, and getting well again. */

import type { Notification } from "../jsonrpc/peer.ts";
import type { BackoffOptions } from "../rois/backoff.ts";
import type { ConnectionState } from "../rois/connection.ts";
import { RoISError } from "../rois/errors.ts";
import type { Bye, Offer, StreamStatusNotification } from "../rois/generated/types.ts";
import type { Call } from "../rois/link.ts";
import { decodableCodecs } from "./codecs.ts";
import type { MediaKind } from "../rois/generated/types.ts";
import { IceServers } from "./ice_servers.ts";
import { Negotiation } from "./negotiation.ts";
import type { CandidateMessage, Effect } from "./negotiation.ts";
import { FIRST_FRAME_WITHIN, PathWatch } from "./path_watch.ts";
import { MediaPeer } from "./peer.ts";
import type { CreatePeerConnection } from "./peer.ts";
import type { Problem, Verb } from "./reconciler.ts";
import { readSample } from "./statistics.ts";
import type { Sample } from "./statistics.ts";
import { RemoteStream } from "./stream.ts";
import type { Attachment } from "./stream.ts";

/** What a `Client` offers to the receiver. */
export interface MediaLink {
  readonly state: ConnectionState;
  readonly call: Call;
  on(name: "state", listener: (state: ConnectionState) => void): () => void;
  on(name: "notification", listener: (notification: Notification) => void): () => void;
}

export interface ReceiverOptions {
  readonly backoff?: BackoffOptions;
  readonly createPeerConnection?: CreatePeerConnection;
  /** What this application can decode, best first. */
  readonly codecs?: (kind: MediaKind) => string[];
}

/** When an engine comes back its profile changes, and that is tried at once; the waits only bound what that misses. */
const BACKOFF: BackoffOptions = { first: 1000, factor: 2, max: 15_000 };

/** Milliseconds after which a connected stream without an offer is given up; the engine should do so after 15 s. */
const OFFER_WITHIN = 20_000;

/** Milliseconds between two looks at the counters, usually and while a first frame is awaited. */
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
  readonly #streams = new Map<string, RemoteStream>();
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

  /** Returns the stream of a component; it is not connected before its `connect` is called. */
  stream(componentRef: string, kind: MediaKind): RemoteStream {
    const known = this.#streams.get(componentRef);
    if (known) return known;
    const operations = {
      ready: () => this.#link.state.name === "connected",
      connect: (ref: string, of: MediaKind) => this.#connect(ref, of),
      perform: (verb: Exclude<Verb, "connect">, streamId: string) => this.#perform(verb, streamId),
      relocate: (each: RemoteStream) => this.#relocate(each),
    };
    const stream = new RemoteStream(componentRef, kind, operations, { ...BACKOFF, ...this.#options.backoff });
    this.#streams.set(componentRef, stream);
    return stream;
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

  async #connect(componentRef: string, kind: MediaKind): Promise<string> {
    const codecs = (this.#options.codecs ?? decodableCodecs)(kind);
    await this.#iceServers.refresh();
    const parameters = [
      { name: "encoding_parameters", data_type_ref: "string", value: JSON.stringify({ codecs }) },
      {
        name: "transport_parameters",
        data_type_ref: "string",
        value: JSON.stringify({ direction: "recvonly" }),
      },
    ];
    const params = { component_ref: componentRef, parameters };
    const { stream_id: streamId = "" } = await this.#link.call(
      "rois.stream.connect_stream",
      params,
      ({ stream_id = "" }) => mayFail(this.#link.call("rois.stream.disconnect_stream", { stream_id })),
    );
    return streamId;
  }

  async #perform(verb: Exclude<Verb, "connect">, streamId: string): Promise<void> {
    await this.#link.call(`rois.stream.${verb}_stream`, { stream_id: streamId });
  }

  /** Attaches a stream to the newest peer that carries it, and closes what nobody needs. */
  #relocate(stream: RemoteStream): void {
    const { streamId } = stream;
    if (streamId !== null) {
      const carriers = [...this.#peers.values()].map(({ peer }) => ({
        peer,
        receiver: peer.receiver(streamId),
      }));
      const newest = carriers.findLast(({ receiver }) => receiver !== undefined);
      if (newest?.receiver) stream.arrival.attach({ peer: newest.peer, receiver: newest.receiver });
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
    this.#iceServers.forget();
    for (const open of this.#peers.values()) open.leaving = true;
    for (const stream of this.#streams.values()) stream.lost(null);
  }

  #notified({ method, params }: Notification): void {
    switch (method) {
      case "signaling.offer":
        return this.#follow(this.#negotiation.offer(params as unknown as Offer));
      case "signaling.candidate": {
        const missing = { sdp_mid: null, sdp_m_line_index: null };
        return this.#follow(
          this.#negotiation.candidate({ ...missing, ...params } as unknown as CandidateMessage),
        );
      }
      case "signaling.bye": {
        const { peer_id: peerId, reason } = params as unknown as Bye;
        return this.#follow(this.#negotiation.end(peerId, reason));
      }
      case "rois.stream.notify_stream_status": {
        const { stream_id: streamId, status } = params as unknown as StreamStatusNotification;
        [...this.#streams.values()].find((each) => each.streamId === streamId)?.reported(status);
        return this.#closeEmptyPeers();
      }
      case "rois.system.profile_changed":
        // The engine may be back, and with it what could not be connected.
        for (const stream of this.#streams.values()) if (stream.streamId === null) stream.retryNow();
    }
  }

  #follow(effects: readonly Effect[]): void {
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
          this.#ended(effect.peerId);
      }
    }
  }

  #openPeer(peerId: string, replaces: string | null): void {
    const create =
      this.#options.createPeerConnection ?? ((configuration) => new RTCPeerConnection(configuration));
    const connection = create({ iceServers: this.#iceServers.current, bundlePolicy: "max-bundle" });
    const peer = new MediaPeer(peerId, connection, {
      onCandidate: (candidate) => this.#follow(this.#negotiation.gathered(peerId, candidate)),
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
      const sdp = await open.peer.apply(offer);
      this.#follow(this.#negotiation.answered(offer.peer_id, offer.generation, sdp));
    } catch (error) {
      if (open.peer.closed) return;
      // Half an answer can't be taken back: the engine ends a peer that is not answered, this side does so now.
      console.error("openrois: the browser refused an offer", error);
      return this.#follow(this.#negotiation.end(offer.peer_id, "the browser refused the offer"));
    }
    for (const stream of this.#streams.values()) this.#relocate(stream);
  }

  /** A peer has ended for good: what arrived by it alone is lost. */
  #ended(peerId: string): void {
    const open = this.#peers.get(peerId);
    if (!open) return;
    this.#closePeer(open.peer);
    for (const stream of this.#streams.values()) {
      if (stream.streamId === null || !open.peer.streamIds.includes(stream.streamId)) continue;
      const elsewhere = [...this.#peers.values()].some(
        ({ peer, leaving }) => !leaving && peer.receiver(stream.streamId ?? "") !== undefined,
      );
      if (!elsewhere) stream.lost("STREAMING_NOT_CONNECTED");
    }
  }

  #closePeer(peer: MediaPeer): void {
    this.#peers.delete(peer.peerId);
    for (const stream of this.#streams.values()) stream.arrival.detach(peer);
    peer.close();
  }

  #closeEmptyPeers(): void {
    const streams = [...this.#streams.values()];
    for (const { peer, leaving } of [...this.#peers.values()]) {
      const used = streams.some(
        ({ arrival }) => arrival.current?.peer === peer || arrival.next?.peer === peer,
      );
      if (!leaving || used) continue;
      this.#negotiation.end(peer.peerId, "replaced");
      this.#closePeer(peer);
    }
  }

  #scheduleTick(): void {
    clearTimeout(this.#timer);
    if (this.#closed) return;
    const quick = [...this.#streams.values()].some((stream) => stream.arrival.next !== null);
    this.#timer = setTimeout(() => void this.#tick(), quick ? QUICK_TICK : TICK);
  }

  async #tick(): Promise<void> {
    clearTimeout(this.#timer);
    const samples = new Map<string, Sample>();
    await Promise.all(
      [...this.#streams.values()].map(async (stream) => {
        const sample = await this.#look(stream);
        if (sample) samples.set(stream.componentRef, sample);
      }),
    );
    for (const stream of this.#streams.values()) this.#missOffer(stream);
    for (const open of [...this.#peers.values()]) this.#judge(open, samples);
    this.#closeEmptyPeers();
    this.#scheduleTick();
  }

  /** Reads the counters of a stream, and moves it to its next place when it flows there. */
  async #look(stream: RemoteStream): Promise<Sample | null> {
    const { current, next } = stream.arrival;
    const [shown, coming] = await Promise.all([readCounters(current), readCounters(next)]);
    if (shown && stream.arrival.current === current) stream.arrival.sampled(shown);
    if (!next || stream.arrival.next !== next) return shown;
    const idle = !stream.expectsMedia && next.peer.connection.connectionState === "connected";
    if (idle || (coming && coming.units > 0)) stream.arrival.promote();
    return coming;
  }

  /** The user should know that there is no offer; and an engine that does not give the stream back is asked to. */
  #missOffer(stream: RemoteStream): void {
    const { streamId } = stream;
    if (streamId === null || !stream.expectsMedia || stream.arrival.located) return;
    const waited = performance.now() - stream.connectedAt;
    if (waited >= FIRST_FRAME_WITHIN && !stream.problem) {
      stream.fail({ kind: "no-media", detail: "the engine made no offer" });
    }
    if (waited < OFFER_WITHIN) return;
    mayFail(this.#link.call("rois.stream.disconnect_stream", { stream_id: streamId }));
    stream.lost("STREAMING_NOT_CONNECTED");
  }

  #judge(open: OpenPeer, samples: ReadonlyMap<string, Sample>): void {
    const carried = [...this.#streams.values()].filter(
      ({ arrival }) => arrival.located && arrival.newest?.peer === open.peer,
    );
    const flows = carried.map((stream) => ({
      streamId: stream.streamId ?? "",
      expected: stream.expectsMedia,
      count: progress(samples.get(stream.componentRef)),
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
        this.#follow(this.#negotiation.end(peerId, error.returnCode));
      }
    }
  }
}

/** An answer or a candidate that is lost leads to a peer that does not connect, and that is noticed. */
function mayFail(asked: Promise<unknown>): void {
  void asked.catch(() => undefined);
}

/** A hidden page may stop decoding, but the packets still come in. */
function progress(sample: Sample | undefined): number {
  if (!sample) return 0;
  return globalThis.document?.visibilityState === "hidden" ? sample.bytes : sample.units;
}

async function readCounters(attachment: Attachment | null): Promise<Sample | null> {
  if (!attachment || attachment.peer.closed) return null;
  const stats = await attachment.receiver.getStats();
  return readSample((stats as unknown as Map<string, never>).values(), performance.now());
}
