"""Sender reports, and receiver reports with the round-trip time from them (RFC 3550 section 6). Pure."""

import struct
from collections import OrderedDict
from dataclasses import dataclass

from openrois_streaming.rtp.ntp import middle, ntp

_SENDER_REPORT = struct.Struct("!BBHLQLLL")
_REMEMBERED = 8
_SMOOTHING = 0.15
# A longer round trip is not credible.
_LONGEST = 10.0


@dataclass(frozen=True, slots=True)
class ReceiverReport:
    """Receiver report on one of our senders (RFC 3550 section 6.4.1).

    `highest_sequence` is extended to 32 bits, `fraction_lost` is 0..1 since the report before, `packets_lost` counts
    from the start, `jitter` is in units of the RTP clock, `round_trip_time` in seconds, smoothed; None if unknown.
    `latest_round_trip` is the newest one, with all present queues.
    """

    highest_sequence: int
    fraction_lost: float
    packets_lost: int
    jitter: int
    round_trip_time: float | None = None
    latest_round_trip: float | None = None


class RoundTrip:
    """Round-trip time to a receiver, by the reports sent to it and its answers."""

    __slots__ = ("_sent", "latest", "smoothed")

    def __init__(self) -> None:
        self.smoothed: float | None = None
        """Seconds; None before the first answer."""
        self.latest: float | None = None
        """Seconds by the newest answer alone."""
        self._sent: OrderedDict[int, float] = OrderedDict()

    def sent(self, timestamp: int, now: float) -> None:
        """Note that a report with this NTP timestamp left at `now`."""
        self._sent[middle(timestamp)] = now
        if len(self._sent) > _REMEMBERED:
            self._sent.popitem(last=False)

    def answered(self, last_report: int, delay: int, now: float) -> None:
        """Apply the last report that a receiver names, and its age in units of 1/65536 s."""
        sent = self._sent.get(last_report)
        if sent is None:
            return
        trip = now - sent - delay / 65536
        if 0 <= trip <= _LONGEST:
            self.latest = trip
            self.smoothed = trip if self.smoothed is None else self.smoothed + _SMOOTHING * (trip - self.smoothed)


def sender_report(ssrc: int, moment: float, timestamp: int, packets: int, octets: int, cname: str) -> bytes:
    """Return a sender report with the source's name: `moment` (epoch seconds) is RTP `timestamp` of `ssrc`."""
    report = _SENDER_REPORT.pack(0x80, 200, 6, ssrc, ntp(moment), timestamp, packets & 0xFFFFFFFF, octets & 0xFFFFFFFF)
    name = cname.encode()[:255]
    chunk = struct.pack("!LBB", ssrc, 1, len(name)) + name + b"\0"
    chunk += bytes(-len(chunk) % 4)
    return report + struct.pack("!BBH", 0x81, 202, len(chunk) // 4) + chunk


def bye(ssrc: int) -> bytes:
    """Return a BYE of `ssrc` (section 6.6), to follow a report."""
    return struct.pack("!BBHL", 0x81, 203, 1, ssrc)
