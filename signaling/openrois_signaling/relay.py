"""Carries signaling between an application and the engine that owns a peer connection. It never parses SDP.

The relay stands in the gateway. Both ends are opaque to it: the owner is an application's session, the engine is
whatever a message upwards is handed to. An engine announces a peer by its first offer (`register`); from then on
messages about that peer pass only between these two, until it is forgotten.
"""

from collections.abc import Awaitable, Callable, Hashable
from dataclasses import dataclass
from typing import Generic, TypeAlias, TypeVar

from openrois_signaling.messages import CANDIDATES_LIMIT, Answer, Candidate, Restart

RATE = 10.0
"""Messages per second that one application may send in the long run."""

BURST = 100.0
"""Messages one application may send at once: two peers with all their candidates need 70."""

PEERS_PER_OWNER = 64
"""Peer connections of one application: one for each engine, two while one replaces another."""


class Refused(Exception):
    """A message of an application was not passed on, or the engine refused it. The text is a sentence for a person.

    `return_code` is RoIS's word for it.
    """

    def __init__(self, return_code: str, reason: str) -> None:
        super().__init__(reason)
        self.return_code = return_code


OwnerT = TypeVar("OwnerT", bound=Hashable)
EngineT = TypeVar("EngineT", bound=Hashable)
Upward: TypeAlias = Answer | Candidate | Restart


@dataclass(slots=True)
class _Peer(Generic[OwnerT, EngineT]):
    owner: OwnerT
    engine: EngineT
    candidates: int = 0


@dataclass(slots=True)
class _Bucket:
    tokens: float
    filled: float

    def admit(self, now: float) -> bool:
        self.tokens = min(BURST, self.tokens + (now - self.filled) * RATE)
        self.filled = now
        if self.tokens < 1:
            return False
        self.tokens -= 1
        return True


class Relay(Generic[OwnerT, EngineT]):
    """Peer ids, their two ends, and what an owner may send.

    Args:
        forward: hands a message to an engine; what it raises passes through, a `Refused` if the engine refuses.
        clock: monotonic seconds.
    """

    def __init__(self, forward: Callable[[EngineT, Upward], Awaitable[None]], clock: Callable[[], float]) -> None:
        self._forward = forward
        self._clock = clock
        self._peers: dict[str, _Peer[OwnerT, EngineT]] = {}
        self._buckets: dict[OwnerT, _Bucket] = {}

    def register(self, peer_id: str, owner: OwnerT, engine: EngineT) -> bool:
        """Note the two ends of a peer. Registering it again with the same ends is fine.

        Returns:
            False if the id belongs to other ends, or the owner has as many peers as it may; nothing changed then, and
            the offer that brought it must not be passed on.
        """
        known = self._peers.get(peer_id)
        if known is not None:
            return known.owner == owner and known.engine == engine
        if sum(peer.owner == owner for peer in self._peers.values()) >= PEERS_PER_OWNER:
            return False
        self._peers[peer_id] = _Peer(owner, engine)
        return True

    def owner(self, peer_id: str, engine: EngineT) -> OwnerT | None:
        """Return the owner that gets `engine`'s messages of a peer; None if that is unknown or another engine's."""
        peer = self._peers.get(peer_id)
        return peer.owner if peer is not None and peer.engine == engine else None

    def forget_peer(self, peer_id: str, engine: EngineT) -> None:
        """Drop a peer that `engine` has ended. Unknown peers and those of another engine are left alone."""
        if self.owner(peer_id, engine) is not None:
            del self._peers[peer_id]

    async def send(self, owner: OwnerT, message: Upward) -> None:
        """Pass a message of `owner` on to the engine of its peer.

        Raises:
            Refused: OUT_OF_RESOURCES: the owner sends faster than `RATE`, or the peer has had all its candidates.
                UNSUPPORTED: the peer is unknown or another application's; the refusal does not say which.
        """
        now = self._clock()
        if not self._buckets.setdefault(owner, _Bucket(BURST, now)).admit(now):
            raise Refused(
                "OUT_OF_RESOURCES", f"one application sends at most {RATE:.0f} messages a second of signaling"
            )
        peer = self._peers.get(message.peer_id)
        if peer is None or peer.owner != owner:
            raise Refused("UNSUPPORTED", "there is no such peer connection")
        if isinstance(message, Candidate):
            if peer.candidates >= CANDIDATES_LIMIT:
                raise Refused("OUT_OF_RESOURCES", f"a peer connection has at most {CANDIDATES_LIMIT} candidates")
            peer.candidates += 1
        await self._forward(peer.engine, message)
