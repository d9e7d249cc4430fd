"""Guard between the sockets of a peer connection and ICE, DTLS and SRTP. Pure.

A peer authenticates its address by ICE connectivity checks; only then its datagrams are read (RFC 8445 section 7, RFC
7675). A peer may find its path valid a moment before this end does, so datagrams from an address under check are held
until that is decided.
"""

from collections.abc import Callable
from dataclasses import dataclass, fields
from enum import IntEnum
from typing import Final, TypeAlias

Source: TypeAlias = tuple[str, int]
"""Address and port that a datagram comes from."""

HELD_LIMIT: Final = 8
"""Datagrams held for each source under check: one flight of a DTLS handshake (RFC 6347 section 4.2.4)."""

SIZE_LIMIT: Final = 1500
"""Bytes of DTLS or SRTP that may pass; both keep below what an Ethernet frame carries, and libsrtp takes no more."""

SOURCES_LIMIT: Final = 64
"""Sources of one socket that may be under check at a time, and that stay proven; a viewer has a handful."""

QUEUE_LIMIT: Final = 1024
"""Datagrams of proven sources that may wait for DTLS and SRTP; beyond that the newest are dropped."""

PAIRS_LIMIT: Final = 100
"""Candidate pairs of one peer connection that are checked (RFC 8445 section 6.1.2.5), those of the highest priority."""

REPLIES_AT_ONCE: Final = 10
REPLIES_PER_SECOND: Final = 5.0
"""Unauthenticated STUN requests that are answered with an error."""


@dataclass(slots=True)
class GuardFigures:
    """Counts of the datagrams that the guard dropped since the start."""

    strangers: int = 0
    """DTLS or SRTP from a source without a successful connectivity check."""
    unknown: int = 0
    """Neither STUN nor DTLS nor SRTP, or empty."""
    malformed: int = 0
    """STUN that cannot be read."""
    unasked: int = 0
    """STUN answers without a request."""
    unauthenticated: int = 0
    """STUN requests without valid credentials; a few of them are answered."""
    forbidden: int = 0
    """Authentic checks from an address that the deployment does not permit, or from too many."""
    oversized: int = 0
    """DTLS or SRTP above `SIZE_LIMIT`."""
    overflow: int = 0
    """Datagrams of proven sources that found the queue full."""
    peer_limit: int = 0
    """Datagrams of proven sources beyond the limit of a peer connection."""
    total_limit: int = 0
    """Datagrams of proven sources beyond the limit of all peer connections together."""
    unreadable: int = 0
    """Authentic RTP and RTCP of a viewer that cannot be parsed."""

    def total(self) -> int:
        """Return the sum of all counts."""
        return sum(getattr(self, each.name) for each in fields(self))


class Allowance:
    """Token bucket that holds `at_once` and fills by `per_second`, in any unit."""

    def __init__(self, clock: Callable[[], float], at_once: float, per_second: float) -> None:
        self._clock = clock
        self._at_once, self._per_second = at_once, per_second
        self._left = at_once
        self._filled = clock()

    def has(self, cost: float = 1.0) -> bool:
        """Tell whether `cost` may pass now."""
        now = self._clock()
        self._left = min(self._at_once, self._left + (now - self._filled) * self._per_second)
        self._filled = now
        return self._left >= cost

    def admits(self, cost: float = 1.0) -> bool:
        """Take `cost` from the bucket if it may pass now; whether it did."""
        if not self.has(cost):
            return False
        self._left -= cost
        return True


class Gate:
    """Gate of one socket. `permits` says which addresses and ports the deployment sends to."""

    __slots__ = ("_figures", "_held", "_permits", "proven")

    def __init__(self, permits: Callable[[str, int], bool], figures: GuardFigures) -> None:
        self.proven: dict[Source, None] = {}
        """Sources with a successful connectivity check, oldest first. A dropped one may be checked again."""
        self._held: dict[Source, list[bytes]] = {}
        self._permits = permits
        self._figures = figures

    @property
    def expected(self) -> tuple[Source, ...]:
        """Sources with a check under way."""
        return tuple(self._held)

    def passes(self, datagram: bytes, source: Source) -> bool:
        """Tell whether DTLS or SRTP may pass now; otherwise it is held or dropped."""
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
        """Note a check with `source`; False if it is not permitted or one too many."""
        if source in self.proven or source in self._held:
            return True
        if len(self._held) >= SOURCES_LIMIT or not self._permits(*source):
            self._figures.forbidden += 1
            return False
        self._held[source] = []
        return True

    def admit(self, source: Source) -> list[bytes]:
        """Let `source` pass after a successful check; returns its held datagrams, oldest first."""
        self.proven[source] = None
        if len(self.proven) > SOURCES_LIMIT:
            del self.proven[next(iter(self.proven))]
        return self._held.pop(source, [])

    def reject(self, source: Source) -> None:
        """Drop the held datagrams of `source` after a failed check."""
        self._figures.strangers += len(self._held.pop(source, []))


STUN_LIMIT: Final = 1500
"""Bytes of a STUN message that are read; connectivity checks have about 100 (RFC 8489 section 6.1 bounds them)."""

_HEADER: Final = 20
_COOKIE: Final = b"\x21\x12\xa4\x42"


class Kind(IntEnum):
    """Protocol of a datagram (RFC 7983 section 7)."""

    STUN = 0
    DTLS = 1
    MEDIA = 2
    """SRTP or SRTCP."""
    OTHER = 3
    """ZRTP, TURN channels, and bytes of no known protocol."""


def _kind(first: int) -> Kind:
    if first < 4:
        return Kind.STUN
    if 20 <= first < 64:
        return Kind.DTLS
    if 128 <= first < 192:
        return Kind.MEDIA
    return Kind.OTHER


KINDS: Final = tuple(_kind(first) for first in range(256))
"""Kind of a datagram by its first byte."""


class StunClass(IntEnum):
    """Class of a STUN message (RFC 8489 section 5)."""

    REQUEST = 0x000
    INDICATION = 0x010
    SUCCESS = 0x100
    ERROR = 0x110


def stun_class(datagram: bytes) -> StunClass | None:
    """Return the class of a STUN message; None if its header is not one of RFC 8489, or it is too long."""
    size = len(datagram)
    if not _HEADER <= size <= STUN_LIMIT or size % 4 or datagram[4:8] != _COOKIE:
        return None
    if int.from_bytes(datagram[2:4], "big") != size - _HEADER:
        return None
    return StunClass(int.from_bytes(datagram[0:2], "big") & 0x110)


def transaction_of(datagram: bytes) -> bytes:
    """Return the transaction id of a STUN message (RFC 8489 section 5)."""
    return datagram[8:_HEADER]
