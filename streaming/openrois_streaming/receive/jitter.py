"""Delay of sound that lets nearly all packets arrive in time. Pure."""

from collections import deque

from openrois_streaming.receive.remote_time import LowestOffset

WINDOW = 3.0
"""Seconds for which late packets are remembered, and the delay stays high after the path has become quiet."""

LONGEST_DELAY = 0.5
"""Seconds; later packets count as lost."""

# Packets that come together are one event: after a stall many are late at once.
_TOGETHER = 0.1
# Share of the intervals in which no packet may be too late.
_SHARE = 0.9
_RESTART = 2.0
# Lateness of a thread that is woken by a timer.
_MARGIN = 0.002


class TargetDelay:
    """Target delay by the arrival of packets, each compared with the fastest of the last seconds.

    Media time plus `base` is the moment at which an undelayed packet arrives; `seconds` are added to that. The delay
    follows repeated stalls of a path, not a single one.
    """

    def __init__(self) -> None:
        self.seconds = _MARGIN
        self._offset = LowestOffset(WINDOW)
        self._slowest: deque[tuple[float, float]] = deque(maxlen=round(WINDOW / _TOGETHER))
        """Largest offset of each interval in which packets came, and the start of that interval."""
        self._late = 0.0
        """The offset that the share of these intervals keeps to."""

    def arrived(self, media_time: float, arrival: float) -> bool:
        """Note a packet whose first sample is at `media_time` (seconds of the RTP clock) and that came at `arrival`.

        Returns:
            Whether its time is unrelated to earlier ones: the source has restarted.
        """
        offset = arrival - media_time
        known = self._offset.value
        restarted = known is not None and abs(offset - known) > _RESTART
        if restarted:
            self._offset.reset()
            self._slowest.clear()
        self._offset.add(offset, arrival)
        if self._remember(arrival, offset):
            ranked = sorted(each for _, each in self._slowest)
            self._late = ranked[int(_SHARE * (len(ranked) - 1))]
        self.seconds = min(max(self._late - self.base, 0.0) + _MARGIN, LONGEST_DELAY)
        return restarted

    @property
    def base(self) -> float:
        """Least difference between arrival and media time; 0 before the first packet."""
        return self._offset.value or 0.0

    def _remember(self, arrival: float, offset: float) -> bool:
        """Note the offset of a packet; whether that of an interval has changed, which that of most packets does not."""
        began, slowest = self._slowest[-1] if self._slowest else (float("-inf"), 0.0)
        if arrival - began < _TOGETHER:
            if offset <= slowest:
                return False
            self._slowest[-1] = (began, offset)
        else:
            self._slowest.append((arrival, offset))
        while self._slowest[0][0] < arrival - WINDOW:
            self._slowest.popleft()
        return True
