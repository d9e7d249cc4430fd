"""Capture times of received media on our clock, from the sender's reports (RFC 3550 section 6.4.1). Pure."""

from typing import NamedTuple

_WINDOW = 30.0
# A greater change is a stepped clock, or a sender whose reports are not credible.
_STEP = 1.0
# Older capture times are wrong.
_OLDEST = 5.0


class LowestOffset:
    """Least offset of the last `window` seconds, and up to as long before that.

    The difference between two clocks is that of the least delayed packet.
    """

    def __init__(self, window: float = _WINDOW) -> None:
        self._window = window
        self._began = 0.0
        self._now: float | None = None
        self._before: float | None = None

    def add(self, offset: float, at: float) -> None:
        """Add an `offset` measured at `at` (seconds)."""
        if self._now is None:
            self._began, self._now = at, offset
        elif at - self._began >= self._window:
            self._began, self._before, self._now = at, self._now, offset
        else:
            self._now = min(self._now, offset)

    def reset(self) -> None:
        """Forget everything."""
        self._now = self._before = None

    @property
    def value(self) -> float | None:
        """Least offset, None before the first."""
        # Playing threads read this while the event loop may reset it: the compared values must not change meanwhile.
        now, before = self._now, self._before
        return now if now is None or before is None else min(now, before)


class RemoteClock:
    """Clock of the other end, which its reports about all of its sources share.

    The fastest packet counts as undelayed: sound and pictures are in sync, and both late by the least travel time of a
    packet.
    """

    def __init__(self) -> None:
        self._offset = LowestOffset()

    def add_report(self, remote: float, arrival: float) -> None:
        """Add a report written at `remote` (seconds of their clock), which came at `arrival` (seconds of ours)."""
        offset = arrival - remote
        known = self._offset.value
        if known is not None and abs(offset - known) > _STEP:
            self._offset.reset()
        self._offset.add(offset, arrival)

    def local(self, remote: float) -> float | None:
        """Return `remote` on our clock; None before the first report."""
        offset = self._offset.value
        return None if offset is None else remote + offset


class CaptureTime(NamedTuple):
    """Capture time `at` on our clock, and `reported` on theirs; None without a credible report."""

    at: float
    reported: float | None


class CaptureTimes:
    """Capture times of the RTP timestamps of one source; `clock_rate` in ticks a second."""

    def __init__(self, clock_rate: int, remote: RemoteClock) -> None:
        self._clock_rate = clock_rate
        self._remote = remote
        self._report: tuple[float, int] | None = None
        self._offset = LowestOffset()

    def reported(self, remote: float, timestamp: int, arrival: float) -> None:
        """Apply a sender report, which pairs `remote` (seconds of their clock) with `timestamp`, unwrapped."""
        self._report = (remote, timestamp)
        self._remote.add_report(remote, arrival)

    def arrived(self, timestamp: int, arrival: float) -> None:
        """Note a packet with `timestamp`, unwrapped, that came at `arrival`."""
        offset = arrival - timestamp / self._clock_rate
        known = self._offset.value
        if known is not None and abs(offset - known) > _STEP:
            self._offset.reset()
        self._offset.add(offset, arrival)

    def captured(self, timestamp: int, now: float) -> CaptureTime:
        """Return the capture time, `now` at the latest; without a credible report by the fastest packet."""
        if self._report is not None:
            remote, reference = self._report
            reported = remote + (timestamp - reference) / self._clock_rate
            moment = self._remote.local(reported)
            if moment is not None and now - _OLDEST <= moment <= now + _STEP:
                return CaptureTime(min(moment, now), reported)
        offset = self._offset.value
        return CaptureTime(now if offset is None else min(timestamp / self._clock_rate + offset, now), None)
