/**
 * The answerer's half of the negotiation, without input or output: messages and outcomes in, effects out.
 *
 * The engine offers, this side answers. A `peer_id` names one peer connection for its whole life; `generation` counts
 * its offers, and one that is not newer than the last is dropped. Offers of one peer are applied one at a time;
 * candidates wait until there is a description to which they belong.
 */

import type { Offer } from "../rois/generated/types.ts";

/** `candidate` is null or empty when there are no more. */
export interface Candidate {
  readonly candidate: string | null;
  readonly sdp_mid: string | null;
  readonly sdp_m_line_index: number | null;
}

export interface CandidateMessage extends Candidate {
  readonly peer_id: string;
  readonly generation: number;
}

export type Effect =
  | { readonly kind: "open"; readonly peerId: string; readonly replaces: string | null }
  | { readonly kind: "apply"; readonly offer: Offer }
  | {
      readonly kind: "send_answer";
      readonly peerId: string;
      readonly generation: number;
      readonly sdp: string;
    }
  | { readonly kind: "add_candidate"; readonly peerId: string; readonly candidate: Candidate }
  | { readonly kind: "send_candidate"; readonly message: CandidateMessage }
  | { readonly kind: "close"; readonly peerId: string; readonly reason: string };

/** The most peer connections at one time: one in use, one that replaces it, and room for a burst of restarts. */
export const MAX_PEERS = 6;
/** Most waiting candidates of one peer, in each direction. */
export const MAX_WAITING_CANDIDATES = 64;
/** Ended peers that are remembered, so that late messages are ignored. */
const MAX_ENDED = 64;

interface PeerState {
  generation: number;
  /** The generation whose answer is being made; null when none is. */
  applying: number | null;
  answered: boolean;
  next: Offer | null;
  readonly remote: Candidate[];
  readonly local: Candidate[];
}

export class Negotiation {
  readonly #peers = new Map<string, PeerState>();
  readonly #ended = new Set<string>();

  /** Takes an offer. */
  offer(offer: Offer): Effect[] {
    if (this.#ended.has(offer.peer_id)) return [];
    const peer = this.#peers.get(offer.peer_id);
    if (!peer) return this.#open(offer);
    if (offer.generation <= peer.generation) return [];
    peer.generation = offer.generation;
    if (peer.applying !== null) {
      peer.next = offer;
      return [];
    }
    peer.applying = offer.generation;
    return [{ kind: "apply", offer }];
  }

  /** Takes the answer to the offer of a generation, once applied. */
  answered(peerId: string, generation: number, sdp: string): Effect[] {
    const peer = this.#peers.get(peerId);
    if (!peer || peer.applying !== generation) return [];
    peer.applying = null;
    peer.answered = true;
    const effects: Effect[] = [{ kind: "send_answer", peerId, generation, sdp }];
    for (const candidate of peer.local.splice(0)) effects.push(sendCandidate(peerId, generation, candidate));
    for (const candidate of peer.remote.splice(0)) effects.push({ kind: "add_candidate", peerId, candidate });
    if (peer.next) {
      const offer = peer.next;
      peer.next = null;
      peer.applying = offer.generation;
      effects.push({ kind: "apply", offer });
    }
    return effects;
  }

  /** Takes a candidate of the engine. Those of earlier generations stay valid: all share one ICE session. */
  candidate(message: CandidateMessage): Effect[] {
    const peer = this.#peers.get(message.peer_id);
    if (!peer || message.generation > peer.generation) return [];
    const { candidate, sdp_mid, sdp_m_line_index } = message;
    const found: Candidate = { candidate, sdp_mid, sdp_m_line_index };
    if (peer.answered && peer.applying === null) {
      return [{ kind: "add_candidate", peerId: message.peer_id, candidate: found }];
    }
    if (peer.remote.length < MAX_WAITING_CANDIDATES) peer.remote.push(found);
    return [];
  }

  /** Takes a candidate that this side gathered. */
  gathered(peerId: string, candidate: Candidate): Effect[] {
    const peer = this.#peers.get(peerId);
    if (!peer) return [];
    if (peer.answered && peer.applying === null) return [sendCandidate(peerId, peer.generation, candidate)];
    if (peer.local.length < MAX_WAITING_CANDIDATES) peer.local.push(candidate);
    return [];
  }

  /** Ends a peer, by the engine's bye or this side's decision. */
  endPeer(peerId: string, reason: string): Effect[] {
    this.#remember(peerId);
    return this.#peers.delete(peerId) ? [{ kind: "close", peerId, reason }] : [];
  }

  /** Ends negotiation on all peers, since the session is gone. Their media may go on. */
  abandon(): void {
    for (const peerId of this.#peers.keys()) this.#remember(peerId);
    this.#peers.clear();
  }

  #open(offer: Offer): Effect[] {
    if (this.#peers.size >= MAX_PEERS) return [];
    const { peer_id: peerId, generation } = offer;
    const fresh = { generation, applying: generation, answered: false, next: null, remote: [], local: [] };
    this.#peers.set(peerId, fresh);
    return [
      { kind: "open", peerId, replaces: offer.replaces ?? null },
      { kind: "apply", offer },
    ];
  }

  #remember(peerId: string): void {
    this.#ended.add(peerId);
    for (const oldest of this.#ended) {
      if (this.#ended.size <= MAX_ENDED) break;
      this.#ended.delete(oldest);
    }
  }
}

function sendCandidate(peerId: string, generation: number, candidate: Candidate): Effect {
  return { kind: "send_candidate", message: { peer_id: peerId, generation, ...candidate } };
}
