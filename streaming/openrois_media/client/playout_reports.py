"""Reports of the playout delay to the engine, which needs it to know when a word is audible. Pure.

Times and delays are seconds.
"""

from typing import Final

__all__ = ["PlayoutReports"]

_EVERY: Final = 2.0
"""Least seconds between two reports of one stream; a greater delay is reported at once."""

_CHANGE: Final = 0.01
"""Least change to report."""

_LATELY: Final = 3.0
"""Seconds for which a measured delay counts: the engine must not wait too short."""


class PlayoutReports:
    """Reports of one stream: the largest delay of the last seconds, when it has changed."""

    def __init__(self) -> None:
        self._stream_id: str | None = None
        self._measured: list[tuple[float, float]] = []
        self._reported: float | None = None
        self._reported_at = float("-inf")

    def due(self, stream_id: str | None, delay: float, now: float) -> float | None:
        """Take a measured delay, about once a second; returns the delay to be reported.

        Args:
            stream_id: the present connection of the stream.
            delay: from arrival to being played; 0 while nothing is.
            now: the time.
        """
        if stream_id != self._stream_id:
            self._stream_id, self._measured, self._reported = stream_id, [], None
            self._reported_at = float("-inf")
        if stream_id is None or not delay:
            return None
        self._measured = [(at, each) for at, each in self._measured if at > now - _LATELY] + [(now, delay)]
        largest = max(each for _, each in self._measured)
        if self._reported is not None:
            change = largest - self._reported
            if abs(change) < _CHANGE or (change < 0 and now - self._reported_at < _EVERY):
                return None
        self._reported, self._reported_at = largest, now
        return largest
