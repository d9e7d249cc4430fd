"""What may pass from the sockets of a peer connection to ICE, DTLS and SRTP. Pure.

A peer proves who it is by ICE connectivity checks, which are authenticated; only then its datagrams are worth a look
(RFC 8445 section 7, RFC 7675). A peer may find its way valid a moment before this end does, so what comes from where a
check is under way is held until that is decided.
"""

from collections.abc import Callable
from dataclasses import dataclass, fields
from typing import Final, TypeAlias

Source: TypeAlias = tuple[str, int]
"""Where a datagram comes from: address and port."""

HELD_LIMIT: Final = 8
"""Datagrams that are held of each source under check: one flight of a DTLS handshake (RFC 6347 section 4.2.4)."""

SIZE_LIMIT: Final = 1500
"""Bytes of DTLS or SRTP that may pass; both keep below what an Ethernet frame carries, and libsrtp takes no more."""

SOURCES_LIMIT: Final = 64
"""Sources of one socket that may be under check at a time, and that stay proven; a viewer has a handful."""

QUEUE_LIMIT: Final = 1024
"""Datagrams of proven sources that may wait for DTLS and SRTP; then the newest are dropped."""

PAIRS_LIMIT: Final = 100
"""Candidate pairs of one peer connection that are checked (RFC 8445 section 6.1.2.5), those of the highest priority."""

REPLIES_AT_ONCE: Final = 10
REPLIES_PER_SECOND: Final = 5.0
"""How many unauthenticated STUN requests are answered with an error."""


@dataclass(slots=True)
class GuardFigures:
    """What was not let pass, in datagrams since the start."""

    strangers: int = 0
    """DTLS or SRTP from where no connectivity check succeeded."""
    unknown: int = 0
    """Neither STUN nor DTLS nor SRTP, or empty."""
    malformed: int = 0
    """STUN that cannot be read."""
    unasked: int = 0
    """STUN answers to no question."""
    unauthenticated: int = 0
    """STUN requests without valid credentials; a few of them are answered."""
    forbidden: int = 0
    """Authentic checks from an address that the deployment does not send to, or from too many."""
    oversized: int = 0
    """DTLS or SRTP that is longer than it ever has to be."""
    overflow: int = 0
    """From proven sources, faster than they are worked off."""
    peer_limit: int = 0
    """From proven sources, more than one peer connection may send."""
    total_limit: int = 0
    """From proven sources, more than all peer connections may send together."""
    unreadable: int = 0
    """RTP and RTCP of a viewer, authentic and decrypted, that cannot be taken in."""

    def total(self) -> int:
        """All of them."""
        return sum(getattr(self, each.name) for each in fields(self))


class Allowance:
    """How much may pass, in whatever it is measured: `at_once`, and then `per_second`."""

    def __init__(self, clock: Callable[[], float], at_once: float, per_second: float) -> None:
        self._clock = clock
        self._at_once, self._per_second = at_once, per_second
        self._left = at_once
        self._filled = clock()

    def has(self, cost: float = 1.0) -> bool:
        """Whether `cost` may pass now."""
        now = self._clock()
        self._left = min(self._at_once, self._left + (now - self._filled) * self._per_second)
        self._filled = now
        return self._left >= cost

    def admits(self, cost: float = 1.0) -> bool:
        """Whether `cost` may pass now; counts it if so."""
        if not self.has(cost):
            return False
        self._left -= cost
        return True


class Gate:
    """Whose datagrams pass one socket. `permits` says which addresses and ports the deployment sends to."""

    __slots__ = ("_figures", "_held", "_permits", "proven")

    def __init__(self, permits: Callable[[str, int], bool], figures: GuardFigures) -> None:
        self.proven: dict[Source, None] = {}
        """Where a connectivity check succeeded, the oldest first. One that is forgotten may prove itself again."""
        self._held: dict[Source, list[bytes]] = {}
        self._permits = permits
        self._figures = figures

    @property
    def expected(self) -> tuple[Source, ...]:
        """Where a check is under way."""
        return tuple(self._held)

    def passes(self, datagram: bytes, source: Source) -> bool:
        """Whether DTLS or SRTP may pass now. If not, it is held or dropped."""
        if len(datagram) > SIZE_LIMIT:
            self._figures.oversized += 1
            return False
        if source in self.proven:
            return True
        held = self._held.get(source)
        if held is None or len(held) >= HELD_LIMIT:
            self._figures.strangers += 1
        else:
            held.append(datagram)
        return False

    def expect(self, source: Source) -> bool:
        """A check with `source` is under way; False if there must be none, for it is forbidden or one too many."""
        if source in self.proven or source in self._held:
            return True
        if len(self._held) >= SOURCES_LIMIT or not self._permits(*source):
            self._figures.forbidden += 1
            return False
        self._held[source] = []
        return True

    def admit(self, source: Source) -> list[bytes]:
        """The check with `source` succeeded; returns what was held of it, oldest first."""
        self.proven[source] = None
        if len(self.proven) > SOURCES_LIMIT:
            del self.proven[next(iter(self.proven))]
        return self._held.pop(source, [])

    def forget(self, source: Source) -> None:
        """The check with `source` failed."""
        self._figures.strangers += len(self._held.pop(source, []))
