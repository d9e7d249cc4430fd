/** One RTCPeerConnection of the answering side. */

import { InputChannels } from "../input/channels.ts";
import type { Offer, SenderClock } from "../rois/generated/types.ts";
import type { Candidate } from "./negotiation.ts";

/** Makes a peer connection; replaced in tests. */
export type CreatePeerConnection = (configuration: RTCConfiguration) => RTCPeerConnection;

/** Returns the track sent in a stream now; null for none. */
export type Outgoing = (streamId: string) => MediaStreamTrack | null;

/** Settings of the delay that a receiver may add; names differ between browsers. */
interface DelayTargets {
  jitterBufferTarget?: number | null;
  playoutDelayHint?: number;
}

/**
 * Milliseconds between the decision to close a connection and its end. A video whose track ends turns black at once,
 * past the page's own drawing: keeping the last picture takes a few frames.
 */
const LINGER = 150;

export interface MediaPeerEvents {
  onCandidate(candidate: Candidate): void;
  onStateChange(): void;
}

/** Applies offers, answers them, and knows which section carries which stream. */
export class MediaPeer {
  readonly peerId: string;
  readonly connection: RTCPeerConnection;
  /** Channels for the operator's input; null where the engine offers none. */
  input: InputChannels | null = null;
  /** Newest capture clocks of the engine's senders. */
  clocks: readonly SenderClock[] = [];
  #sections = new Map<string, RTCRtpTransceiver>();
  #closed = false;

  constructor(peerId: string, connection: RTCPeerConnection, events: MediaPeerEvents) {
    this.peerId = peerId;
    this.connection = connection;
    connection.onicecandidate = ({ candidate }) => {
      if (this.#closed) return;
      events.onCandidate({
        candidate: candidate?.candidate || null,
        sdp_mid: candidate?.sdpMid ?? null,
        sdp_m_line_index: candidate?.sdpMLineIndex ?? null,
      });
    };
    connection.onconnectionstatechange = () => {
      if (!this.#closed) events.onStateChange();
    };
  }

  get closed(): boolean {
    return this.#closed;
  }

  /** The streams of the last applied offer. */
  get streamIds(): readonly string[] {
    return [...this.#sections.keys()];
  }

  section(streamId: string): RTCRtpTransceiver | undefined {
    return this.#sections.get(streamId);
  }

  /**
   * Applies an offer and returns the answer's SDP.
   *
   * @throws DOMException when the browser refuses the offer, or the peer was closed meanwhile
   */
  async apply(offer: Offer, outgoing: Outgoing): Promise<string> {
    await this.connection.setRemoteDescription({ type: "offer", sdp: offer.sdp });
    if (offer.sdp.includes("m=application ")) this.input ??= new InputChannels(this.connection);
    const idle = new Map(this.connection.getTransceivers().map((each) => [each.mid, each]));
    const sections = new Map<string, RTCRtpTransceiver>();
    for (const { mid, stream_id, direction } of offer.streams) {
      const transceiver = idle.get(mid);
      if (!transceiver) continue;
      idle.delete(mid);
      sections.set(stream_id, transceiver);
      if (direction !== "sendonly") playAtOnce(transceiver.receiver);
      transceiver.direction = direction;
      if (direction !== "recvonly") await transceiver.sender.replaceTrack(outgoing(stream_id));
    }
    for (const transceiver of idle.values()) {
      // A game engine that offers by itself offers all that it has: what was not connected is not taken.
      transceiver.direction = "inactive";
      // What was sent in a section whose stream is over must not go to the next stream that gets it.
      if (transceiver.sender.track) await transceiver.sender.replaceTrack(null);
    }
    await this.connection.setLocalDescription(await this.connection.createAnswer());
    this.#sections = sections;
    return this.connection.localDescription?.sdp ?? "";
  }

  /** Adds a candidate of the engine. An unusable one is skipped, as in ICE. */
  async addCandidate({ candidate, sdp_mid, sdp_m_line_index }: Candidate): Promise<void> {
    const init = { candidate: candidate ?? "", sdpMid: sdp_mid, sdpMLineIndex: sdp_m_line_index };
    try {
      await this.connection.addIceCandidate(candidate ? init : undefined);
    } catch (error) {
      if (!this.#closed) console.warn("openrois: a candidate of the engine is unusable", error);
    }
  }

  /** Ends all callbacks of this peer; its tracks end a moment later. */
  close(): void {
    if (this.#closed) return;
    this.#closed = true;
    setTimeout(() => this.connection.close(), LINGER);
  }
}

/** Live means now: the browser shall not hold frames back to smooth them. */
function playAtOnce(receiver: RTCRtpReceiver): void {
  const targets = receiver as DelayTargets;
  if ("jitterBufferTarget" in targets) targets.jitterBufferTarget = 0;
  else if ("playoutDelayHint" in targets) (targets as DelayTargets).playoutDelayHint = 0;
}
