"""Rates over a sliding window: of the bytes sent to a viewer, and of the packets lost. Pure."""

from collections import deque
from typing import Final, Protocol

WINDOW: Final = 1.0
"""Seconds: as long as the window of the receivers' own estimators, so that both cover the same time."""

# Reports over fewer packets say little: of 60 at 5 % random loss, one in 300 has more than 15 %.
_LEAST_PACKETS = 60
_MOST_REPORTS = 64


class RateMeter:
    """Bit rate over the last second."""

    __slots__ = ("_counts", "_since", "_total")

    def __init__(self, now: float) -> None:
        self._since = now
        self._counts: deque[tuple[float, int]] = deque()
        self._total = 0

    def count(self, size: int, now: float) -> None:
        """Count `size` bytes at the time `now`."""
        self._counts.append((now, size))
        self._total += size
        self._drop_old(now)

    def rate(self, now: float) -> float:
        """Return the bit/s over the last second, or since the meter was made if that is less."""
        self._drop_old(now)
        return self._total * 8 / max(0.1, min(WINDOW, now - self._since))

    def _drop_old(self, now: float) -> None:
        counts, past = self._counts, now - WINDOW
        while counts and counts[0][0] <= past:
            self._total -= counts.popleft()[1]


class LossReport(Protocol):
    """Losses that a receiver reports (RFC 3550 section 6.4.1)."""

    @property
    def highest_sequence(self) -> int:
        """Newest packet received, extended to 32 bits."""
        ...

    @property
    def packets_lost(self) -> int:
        """Packets lost since the first one."""
        ...

    @property
    def fraction_lost(self) -> float:
        """Share lost since the report before, 0..1."""
        ...


class LossMeter:
    """Share of packets that a receiver lost lately, from the running counts of its reports."""

    __slots__ = ("_fresh", "_reports")

    def __init__(self) -> None:
        self._reports: deque[tuple[int, int]] = deque(maxlen=_MOST_REPORTS)
        self._fresh = True

    def reset(self) -> None:
        """Begin anew: losses until the next report do not count."""
        self._reports.clear()
        self._fresh = False

    def add_report(self, report: LossReport) -> float | None:
        """Return the share (0..1) lost of the newest packets, 60 of them at least; None if there were fewer.

        The first report covers all packets before it. Counts that go back are those of another receiver.
        """
        highest, lost = report.highest_sequence, report.packets_lost
        if self._reports and highest < self._reports[-1][0]:
            self._reports.clear()
        self._reports.append((highest, lost))
        if self._fresh:
            self._fresh = False
            return report.fraction_lost
        for before, lost_before in reversed(self._reports):
            if highest - before >= _LEAST_PACKETS:
                while self._reports[0][0] < before:
                    self._reports.popleft()
                return max(0.0, (lost - lost_before) / (highest - before))
        return None
