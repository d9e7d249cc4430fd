"""Limits on the datagrams of one peer connection, and of all, before they are queued or decrypted. Pure.

The kinds differ in cost: to decrypt a report (RTCP) and to retransmit what it asks for takes longer than to receive a
picture's packet, and to verify a connectivity check (STUN) longer still. Each kind has a token bucket (RFC 2697) of its
own; packets and bytes of all kinds together have one each.
"""

from collections.abc import Callable
from dataclasses import dataclass, fields
from enum import Enum
from typing import Final

RTCP_PER_SECOND: Final = 200
"""RTCP packets of one peer connection. Chromium sends 11 a second while it loses a tenth of 720p30."""

DTLS_PER_SECOND: Final = 500
"""DTLS records of one peer connection, which carry its data channels: the input of a person makes 150 a second."""

CHECKS_PER_SECOND: Final = 100
"""Connectivity checks of one peer connection, answers included. Chromium sends 13 in the first second, then fewer."""

BURST: Final = 0.5
"""Seconds' worth of packets and bytes that may come at once, of one peer connection and of all; of a kind it is 1 s."""

SHARE: Final = 125
"""Packets a second that each peer connection may send, however much the others send."""

CONTROL_SHARE: Final = 75
"""Packets of that share that RTP may not use, so that a camera leaves room for reports, checks and input."""

PERSISTENCE: Final = 3.0
"""Seconds for which a peer connection may exceed its limits; then it ends."""

RESPITE: Final = 1.0
"""Seconds without excess after which that time starts anew."""


@dataclass(frozen=True, slots=True)
class AdmissionSettings:
    """Limits on what is admitted from the network each second.

    A camera of 720p30 at 4 Mbit/s sends 450 packets and 0.5 MB a second, a microphone 50 packets.

    Attributes:
        peer_packets: packets of one peer connection.
        peer_bytes: bytes of one peer connection.
        total_packets: packets of all peer connections.
        total_bytes: bytes of all peer connections.
    """

    peer_packets: int = 2_000
    peer_bytes: int = 2_500_000
    total_packets: int = 8_000
    total_bytes: int = 12_500_000

    def __post_init__(self) -> None:
        for each in fields(self):
            if getattr(self, each.name) < 1:
                option = f"--{each.name.replace('_', '-')}"
                raise ValueError(f"{option} must be 1 or more, not {getattr(self, each.name)}")


class Traffic(Enum):
    """Kinds of datagrams, by the cost of receiving them."""

    CHECK = 0
    DTLS = 1
    RTCP = 2
    RTP = 3


class Verdict(Enum):
    """Decision on a datagram."""

    ADMITTED = 0
    PEER_LIMIT = 1
    """The peer connection exceeds its limit."""
    TOTAL_LIMIT = 2
    """All peer connections together exceed their limit."""


def media_traffic(datagram: bytes) -> Traffic:
    """Tell DTLS, RTCP and RTP apart by their unencrypted bytes (RFC 7983 section 7, RFC 5761 section 4)."""
    if datagram[0] < 64:
        return Traffic.DTLS
    return Traffic.RTCP if len(datagram) > 1 and 64 <= datagram[1] & 0x7F < 96 else Traffic.RTP


class _Bucket:
    """Token bucket (RFC 2697)."""

    __slots__ = ("_filled", "_left", "_per_second", "_size")

    def __init__(self, per_second: float, seconds: float, now: float) -> None:
        self._size = self._left = per_second * seconds
        self._per_second = per_second
        self._filled = now

    def admits(self, cost: float, now: float, kept: float = 0.0) -> bool:
        """Take `cost` from the bucket if it fits with `kept` left for others; whether it did."""
        left = min(self._size, self._left + (now - self._filled) * self._per_second)
        self._filled = now
        if left < cost + kept:
            self._left = left
            return False
        self._left = left - cost
        return True


class TotalAdmission:
    """Limit on all peer connections of an engine together.

    Args:
        settings: the limits.
        clock: monotonic seconds.
    """

    def __init__(self, settings: AdmissionSettings, clock: Callable[[], float]) -> None:
        self.settings = settings
        self.clock = clock
        now = clock()
        self._packets = _Bucket(settings.total_packets, BURST, now)
        self._bytes = _Bucket(settings.total_bytes, BURST, now)

    def admits(self, octets: int, now: float) -> bool:
        """Take one packet from the limit if it fits; whether it did."""
        return self._packets.admits(1, now) and self._bytes.admits(octets, now)


class Admission:
    """Limit on one peer connection, as a part of the limit on all.

    Args:
        total: the limit on all peer connections.
    """

    def __init__(self, total: TotalAdmission) -> None:
        settings, now = total.settings, total.clock()
        self._total = total
        self._kinds = {
            Traffic.CHECK: _Bucket(CHECKS_PER_SECOND, 1, now),
            Traffic.DTLS: _Bucket(DTLS_PER_SECOND, 1, now),
            Traffic.RTCP: _Bucket(RTCP_PER_SECOND, 1, now),
        }
        self._packets = _Bucket(settings.peer_packets, BURST, now)
        self._bytes = _Bucket(settings.peer_bytes, BURST, now)
        self._share = _Bucket(SHARE, 1, now)
        self._excess_since = self._excess_at = float("-inf")

    def judge(self, traffic: Traffic, octets: int) -> Verdict:
        """Decide on a datagram of so many bytes that arrived now."""
        now = self._total.clock()
        kind = self._kinds.get(traffic)
        within = (kind is None or kind.admits(1, now)) and self._packets.admits(1, now)
        if not (within and self._bytes.admits(octets, now)):
            if now - self._excess_at > RESPITE:
                self._excess_since = now
            self._excess_at = now
            return Verdict.PEER_LIMIT
        kept = CONTROL_SHARE if traffic is Traffic.RTP else 0.0
        if self._total.admits(octets, now) or self._share.admits(1, now, kept):
            return Verdict.ADMITTED
        return Verdict.TOTAL_LIMIT

    @property
    def persists(self) -> bool:
        """Whether the peer connection has exceeded its limits for longer than `PERSISTENCE`."""
        lately = self._total.clock() - self._excess_at <= RESPITE
        return lately and self._excess_at - self._excess_since >= PERSISTENCE
