"""How long sound has to wait so that nearly all of it is there in time. Pure."""

from collections import deque

from openrois_streaming.receive.remote_time import LowestOffset

WINDOW = 3.0
"""Seconds for which late packets are remembered: so long the delay stays high after the path has become quiet."""

LONGEST_DELAY = 0.5
"""Seconds; what is later than that counts as lost."""

# Packets that come together are one event: after a stall many are late, but that was one time only.
_TOGETHER = 0.1
# The share of the times in which no packet may be too late.
_SHARE = 0.9
_RESTART = 2.0
# What a thread that is woken by a timer is late by.
_MARGIN = 0.002


class TargetDelay:
    """Follows the arrival of packets, each by how much later it came than the fastest of the last seconds.

    `base` is what is to be added to a media time for the moment at which its packet arrives if nothing delays it;
    `seconds` are to be added to that. A path that stands still once is not waited for, one that does so again and again
    is.
    """

    def __init__(self) -> None:
        self.seconds = _MARGIN
        self._offset = LowestOffset(WINDOW)
        self._slowest: deque[tuple[float, float]] = deque(maxlen=round(WINDOW / _TOGETHER))
        """The largest offset of each time in which packets came, and when that began."""

    def arrived(self, media_time: float, arrival: float) -> bool:
        """A packet whose first sample is at `media_time` (seconds of the RTP clock) came at `arrival`.

        Returns:
            Whether its time has nothing to do with those before: the source has started anew.
        """
        offset = arrival - media_time
        known = self._offset.value
        restarted = known is not None and abs(offset - known) > _RESTART
        if restarted:
            self._offset.reset()
            self._slowest.clear()
        self._offset.add(offset, arrival)
        self._remember(arrival, offset)
        ranked = sorted(each for _, each in self._slowest)
        late = ranked[int(_SHARE * (len(ranked) - 1))] - self.base
        self.seconds = min(max(late, 0.0) + _MARGIN, LONGEST_DELAY)
        return restarted

    @property
    def base(self) -> float:
        """The least difference between arrival and media time; 0 before the first packet."""
        return self._offset.value or 0.0

    def _remember(self, arrival: float, offset: float) -> None:
        if self._slowest and arrival - self._slowest[-1][0] < _TOGETHER:
            began, slowest = self._slowest[-1]
            self._slowest[-1] = (began, max(offset, slowest))
        else:
            self._slowest.append((arrival, offset))
        while self._slowest[0][0] < arrival - WINDOW:
            self._slowest.popleft()
