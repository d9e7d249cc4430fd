"""Whether an application's media really arrives, judged by the whole frames that came. Pure.

Times are seconds of one monotonic clock and are given by the caller.
"""

from collections.abc import Sequence

from openrois_streaming.liveness import STALL, Verdict

_WORST_FIRST = (Verdict.STALLED, Verdict.UNANSWERED, Verdict.UNDECIDED, Verdict.FLOWING)


class Arrival:
    """The progress of one receiver. Time in which nothing is wanted of it does not count."""

    __slots__ = ("_opened",)

    def __init__(self) -> None:
        self._opened: float | None = None

    def opened(self, now: float) -> None:
        """From now on frames are wanted."""
        self._opened = now

    def closed(self) -> None:
        """From now on no frames are wanted."""
        self._opened = None

    def judge(self, now: float, last_frame_at: float | None) -> Verdict:
        """Whether media arrives; `last_frame_at` is when the last whole frame came, None if none has come yet."""
        if self._opened is None:
            return Verdict.UNDECIDED
        if last_frame_at is None or last_frame_at < self._opened:
            return Verdict.UNDECIDED if now - self._opened < STALL else Verdict.STALLED
        return Verdict.FLOWING if now - last_frame_at < STALL else Verdict.STALLED


def both(verdicts: Sequence[Verdict]) -> Verdict:
    """What is known about a stream whose directions were judged each: it flows when all of them do."""
    for verdict in _WORST_FIRST:
        if verdict in verdicts:
            return verdict
    return Verdict.UNDECIDED
