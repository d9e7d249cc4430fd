"""Answerer's half of the negotiation: messages and outcomes in, effects out. Pure.

The engine offers, this end answers. A `peer_id` names one peer connection for its whole life; `generation` counts its
offers, and one that is not newer than the last is dropped. Offers of one peer are applied one at a time; candidates
wait until there is a description to which they belong.
"""

from collections import deque
from dataclasses import dataclass, field
from typing import Final, TypeAlias

from openrois_signaling.messages import Answer, Candidate, Offer

__all__ = [
    "MAX_PEERS",
    "MAX_WAITING_CANDIDATES",
    "AddCandidate",
    "Apply",
    "Close",
    "Effect",
    "Negotiation",
    "Open",
    "SendAnswer",
    "SendCandidate",
]

MAX_PEERS: Final = 16
"""Peer connections at one time, of all engines; while one is replaced there are two of it."""

MAX_WAITING_CANDIDATES: Final = 64
"""Waiting candidates of one peer, in each direction."""

_MAX_ENDED: Final = 64
"""Ended peers that are remembered, so that late messages are ignored."""


@dataclass(frozen=True, slots=True)
class Open:
    """Open a peer connection; it replaces the one named."""

    peer_id: str
    replaces: str | None


@dataclass(frozen=True, slots=True)
class Apply:
    """Apply an offer; `Negotiation.answered` gets the answer."""

    offer: Offer


@dataclass(frozen=True, slots=True)
class SendAnswer:
    """Send the engine an answer."""

    answer: Answer


@dataclass(frozen=True, slots=True)
class AddCandidate:
    """Add a candidate of the engine; None: there are no more."""

    peer_id: str
    candidate: str | None


@dataclass(frozen=True, slots=True)
class SendCandidate:
    """Send the engine a candidate of this end."""

    candidate: Candidate


@dataclass(frozen=True, slots=True)
class Close:
    """Close a peer connection."""

    peer_id: str
    reason: str


Effect: TypeAlias = Open | Apply | SendAnswer | AddCandidate | SendCandidate | Close


@dataclass(slots=True)
class _PeerState:
    generation: int
    applying: int | None
    """The generation whose answer is being made."""
    mid: str = ""
    answered: bool = False
    next: Offer | None = None
    remote: list[str | None] = field(default_factory=list)
    local: list[str | None] = field(default_factory=list)


class Negotiation:
    """Negotiation of all peer connections of an application."""

    def __init__(self) -> None:
        self._peers: dict[str, _PeerState] = {}
        self._ended: deque[str] = deque(maxlen=_MAX_ENDED)

    def offer(self, offer: Offer) -> list[Effect]:
        """Take an offer."""
        if offer.peer_id in self._ended:
            return []
        peer = self._peers.get(offer.peer_id)
        if peer is None:
            return self._open(offer)
        if offer.generation <= peer.generation:
            return []
        peer.generation = offer.generation
        if peer.applying is not None:
            peer.next = offer
            return []
        peer.applying = offer.generation
        return [Apply(offer)]

    def answered(self, peer_id: str, generation: int, sdp: str, mid: str) -> list[Effect]:
        """Take the answer to an offer; candidates of this end belong to the section `mid`."""
        peer = self._peers.get(peer_id)
        if peer is None or peer.applying != generation:
            return []
        peer.applying, peer.answered, peer.mid = None, True, mid
        effects: list[Effect] = [SendAnswer(Answer(peer_id=peer_id, generation=generation, sdp=sdp))]
        effects += [_own(peer_id, generation, mid, candidate) for candidate in peer.local]
        effects += [AddCandidate(peer_id, candidate) for candidate in peer.remote]
        peer.local.clear()
        peer.remote.clear()
        if peer.next is not None:
            offer, peer.next = peer.next, None
            peer.applying = offer.generation
            effects.append(Apply(offer))
        return effects

    def candidate(self, message: Candidate) -> list[Effect]:
        """Take a candidate of the engine. Those of earlier generations stay valid: all share one ICE session."""
        peer = self._peers.get(message.peer_id)
        if peer is None or message.generation > peer.generation:
            return []
        candidate = message.candidate or None
        if peer.answered and peer.applying is None:
            return [AddCandidate(message.peer_id, candidate)]
        if len(peer.remote) < MAX_WAITING_CANDIDATES:
            peer.remote.append(candidate)
        return []

    def gathered(self, peer_id: str, candidate: str | None) -> list[Effect]:
        """Take a candidate that this end has found after its first answer; None: there are no more."""
        peer = self._peers.get(peer_id)
        if peer is None:
            return []
        if peer.answered and peer.applying is None:
            return [_own(peer_id, peer.generation, peer.mid, candidate)]
        if len(peer.local) < MAX_WAITING_CANDIDATES:
            peer.local.append(candidate)
        return []

    def end_peer(self, peer_id: str, reason: str) -> list[Effect]:
        """End a peer, by the engine's bye or by a decision of this end."""
        self._remember(peer_id)
        return [] if self._peers.pop(peer_id, None) is None else [Close(peer_id, reason)]

    def abandon(self) -> None:
        """End the negotiation of all peers, as the session is gone. Their media may go on."""
        for peer_id in self._peers:
            self._remember(peer_id)
        self._peers.clear()

    def _open(self, offer: Offer) -> list[Effect]:
        if len(self._peers) >= MAX_PEERS:
            return []
        self._peers[offer.peer_id] = _PeerState(offer.generation, offer.generation)
        return [Open(offer.peer_id, offer.replaces), Apply(offer)]

    def _remember(self, peer_id: str) -> None:
        if peer_id not in self._ended:
            self._ended.append(peer_id)


def _own(peer_id: str, generation: int, mid: str, candidate: str | None) -> SendCandidate:
    return SendCandidate(Candidate(peer_id=peer_id, generation=generation, candidate=candidate, sdp_mid=mid))
