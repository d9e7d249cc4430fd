/** One RTCPeerConnection of the answering side. */

import type { Offer } from "../rois/generated/types.ts";
import type { Candidate } from "./negotiation.ts";

/** Makes a peer connection; replaced in tests. */
export type CreatePeerConnection = (configuration: RTCConfiguration) => RTCPeerConnection;

/** What the receiver of a section can be told about the delay it may add; names differ between browsers. */
interface DelayTargets {
  jitterBufferTarget?: number | null;
  playoutDelayHint?: number;
}

/**
 * Milliseconds between the decision to close a connection and its end. A video whose track ends turns black at once,
 * past the page's own drawing: whoever keeps the last picture needs a few frames to put it on the screen before.
 */
const LINGER = 150;

export interface MediaPeerEvents {
  onCandidate(candidate: Candidate): void;
  onStateChange(): void;
}

/** Applies offers, answers them, and knows which receiver carries which stream. */
export class MediaPeer {
  readonly peerId: string;
  readonly connection: RTCPeerConnection;
  #receivers = new Map<string, RTCRtpReceiver>();
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

  /** The streams that the last applied offer brings to this side. */
  get streamIds(): readonly string[] {
    return [...this.#receivers.keys()];
  }

  receiver(streamId: string): RTCRtpReceiver | undefined {
    return this.#receivers.get(streamId);
  }

  /**
   * Applies an offer and returns the answer's SDP.
   *
   * @throws DOMException when the browser refuses the offer, or the peer was closed meanwhile
   */
  async apply(offer: Offer): Promise<string> {
    await this.connection.setRemoteDescription({ type: "offer", sdp: offer.sdp });
    await this.connection.setLocalDescription(await this.connection.createAnswer());
    const byMid = new Map(this.connection.getTransceivers().map((each) => [each.mid, each.receiver]));
    this.#receivers = new Map();
    for (const section of offer.streams) {
      const receiver = byMid.get(section.mid);
      if (!receiver || section.direction === "sendonly") continue;
      playAtOnce(receiver);
      this.#receivers.set(section.stream_id, receiver);
    }
    return this.connection.localDescription?.sdp ?? "";
  }

  /** Adds a candidate of the engine. One that the browser can't use is skipped, as ICE does. */
  async addCandidate({ candidate, sdp_mid, sdp_m_line_index }: Candidate): Promise<void> {
    const init = { candidate: candidate ?? "", sdpMid: sdp_mid, sdpMLineIndex: sdp_m_line_index };
    try {
      await this.connection.addIceCandidate(candidate ? init : undefined);
    } catch (error) {
      if (!this.#closed) console.warn("openrois: a candidate of the engine is unusable", error);
    }
  }

  /** Nothing is heard from this peer any more; its tracks end a moment later. */
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
