"""How many datagrams are admitted, of one peer connection and of all, before they are queued or decrypted. Pure.

Each kind costs the engine something else: to decrypt a report (RTCP) and to send again what it asks for takes longer
than to receive a picture's packet, and to verify a connectivity check (STUN) longer still. Each has a bucket of its own
(RFC 2697 calls them token buckets); packets and bytes of all kinds together have one each.
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
"""Packets a second that one peer connection may send whatever the others do."""

CONTROL_SHARE: Final = 75
"""Packets of it that RTP leaves: a camera's would take all, and reports, connectivity checks and input be lost."""

PERSISTENCE: Final = 3.0
"""Seconds for which a peer connection may send too much; then it ends."""

RESPITE: Final = 1.0
"""Seconds without excess after which they count anew."""


@dataclass(frozen=True, slots=True)
class AdmissionSettings:
    """How much is admitted from the network, each second.

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
    """What a datagram is, by what it costs to take it in."""

    CHECK = 0
    DTLS = 1
    RTCP = 2
    RTP = 3


class Verdict(Enum):
    """What becomes of a datagram."""

    ADMITTED = 0
    PEER_LIMIT = 1
    """Its peer connection sends too much."""
    TOTAL_LIMIT = 2
    """All together send too much."""


def media_traffic(datagram: bytes) -> Traffic:
    """Tell DTLS, RTCP and RTP apart by what is never encrypted (RFC 7983 section 7, RFC 5761 section 4)."""
    if datagram[0] < 64:
        return Traffic.DTLS
    return Traffic.RTCP if len(datagram) > 1 and 64 <= datagram[1] & 0x7F < 96 else Traffic.RTP


class _Bucket:
    """So much at once, and then so much a second."""

    __slots__ = ("_filled", "_left", "_per_second", "_size")

    def __init__(self, per_second: float, seconds: float, now: float) -> None:
        self._size = self._left = per_second * seconds
        self._per_second = per_second
        self._filled = now

    def admits(self, cost: float, now: float, kept: float = 0.0) -> bool:
        """Tell whether `cost` fits, with so much `kept` for others, and take it if so."""
        left = min(self._size, self._left + (now - self._filled) * self._per_second)
        self._filled = now
        if left < cost + kept:
            self._left = left
            return False
        self._left = left - cost
        return True


class TotalAdmission:
    """What all peer connections of an engine may send together.

    Args:
        settings: how much that is.
        clock: monotonic seconds.
    """

    def __init__(self, settings: AdmissionSettings, clock: Callable[[], float]) -> None:
        self.settings = settings
        self.clock = clock
        now = clock()
        self._packets = _Bucket(settings.total_packets, BURST, now)
        self._bytes = _Bucket(settings.total_bytes, BURST, now)

    def admits(self, octets: int, now: float) -> bool:
        """Tell whether one more packet fits."""
        return self._packets.admits(1, now) and self._bytes.admits(octets, now)


class Admission:
    """What one peer connection may send, as a part of what all may.

    Args:
        total: what all may send together.
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
        """Tell what becomes of a datagram of so many bytes that came now."""
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
        """Whether the peer connection has been sending too much for longer than it may."""
        lately = self._total.clock() - self._excess_at <= RESPITE
        return lately and self._excess_at - self._excess_since >= PERSISTENCE
