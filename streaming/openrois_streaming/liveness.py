"""Liveness of streams and viewers, judged from measured frames, reports and signs of life. Pure.

Times are seconds of one monotonic clock and are given by the caller.
"""

from collections.abc import Sequence
from enum import Enum

STALL = 1.0
"""Seconds without a frame after which an open stream has stalled."""

REPORT_AGE = {"video": 2.0, "audio": 8.0}
"""Seconds for which a receiver's report of progress is valid. Browsers report on video every second and on audio every
2.5 to 7.5 s (RFC 3550 section 6.3.1: 5 s, randomised by half)."""

SILENCE = 3.8
"""Seconds without a sign of life after which a viewer is gone: a closed tab is noticed within 4 s, the time to the next
check included. ICE consent alone takes 30 s (RFC 7675)."""

PROBE_AFTER = 2.0
"""Seconds of silence after which the viewer is asked for a sign of life. A viewer of audio alone, or of a suspended
stream, has no reason to send one by itself."""

PROBE_INTERVAL = 0.5
"""Seconds between two such requests."""


class Verdict(Enum):
    """Judgement on one stream of one peer connection."""

    FLOWING = "flowing"
    STALLED = "stalled"
    UNDECIDED = "undecided"
    """The stream was opened too recently to be judged."""
    UNANSWERED = "unanswered"
    """Frames leave; a sign of life from the viewer is awaited."""


class Flow:
    """Progress of one sender: frames that left, and the receiver's reports on them.

    Time in which the stream is suspended does not count, nor do pauses between frames that are meant.
    `highest_sequence` is what the receiver has reported about this sender for an earlier stream.
    """

    __slots__ = ("_advanced", "_due", "_first", "_highest", "_kind", "_last", "_opened", "_pause", "_renewed")

    def __init__(self, kind: str, highest_sequence: int | None = None) -> None:
        self._kind = kind
        self._highest = highest_sequence
        self._opened: float | None = None
        self._first: float | None = None
        self._last: float | None = None
        self._pause = 0.0
        """Intended pause after the last frame, in seconds."""
        self._advanced: float | None = None
        """Since when a report is awaited, if there was one before: when the receiver reported progress last, or when
        the first frame left since then without a gap, or when it was `opened` since then, or sound returned after a
        gap."""
        self._due = False
        """Whether a frame has left since the receiver reported progress."""
        self._renewed = False
        """Whether the wait has begun anew after a gap, since the receiver reported progress or it was opened."""

    def opened(self, now: float) -> None:
        """Expect frames from now on. A receiver that reported progress before is trusted afresh."""
        self._opened, self._first, self._last, self._renewed = now, None, None, False
        if self._advanced is not None:
            self._advanced = now

    def closed(self) -> None:
        """Expect no frames from now on."""
        self._opened = None

    def left(self, now: float, pause: float = 0.0) -> None:
        """Note that a frame was handed to the network, and that `pause` seconds may follow it."""
        if self._advanced is not None and self._last is not None:
            if self._moves(now, pause):
                if not self._due:
                    # Until now there was nothing to report.
                    self._advanced = now
            elif self._kind == "audio" and not self._renewed:
                # Sound is back, and the next report on it is seconds away. Only once: gaps alone do not keep a stream
                # flowing.
                self._advanced, self._renewed = now, True
        self._last, self._pause, self._due = now, pause, True
        if self._first is None:
            self._first = now

    def reported(self, highest_sequence: int, now: float) -> None:
        """Note the newest packet that the receiver reports of this stream (RFC 3550 section 6.4.1)."""
        if highest_sequence != self._highest:
            self._highest = highest_sequence
            self._advanced, self._due, self._renewed = now, False, False

    def judge(self, now: float, seen: float, pause: float = 0.0) -> Verdict:
        """Judge whether media reaches the viewer.

        Args:
            now: the time.
            seen: when the viewer last gave any sign of life.
            pause: seconds that may pass between two frames now, beside those of a source.
        """
        if self._opened is None:
            return Verdict.UNDECIDED
        if self._first is None or self._last is None:
            return Verdict.UNDECIDED if now - self._opened < STALL else Verdict.STALLED
        if not self._moves(now, pause):
            return Verdict.STALLED
        return self._received(self._first, now, seen)

    def _moves(self, now: float, pause: float) -> bool:
        """Tell whether the last frame left recently enough."""
        return self._last is not None and now - self._last < STALL + max(pause, self._pause)

    def _received(self, first: float, now: float, seen: float) -> Verdict:
        age = REPORT_AGE[self._kind]
        if self._advanced is not None:
            return Verdict.FLOWING if not self._due or now - self._advanced <= age else Verdict.STALLED
        if now - first > age:
            return Verdict.STALLED
        if self._kind == "video":
            return Verdict.UNDECIDED
        # The first report on audio comes after several seconds. Until then packets that leave towards a live viewer
        # count; the first report on video comes within a second and is awaited.
        return Verdict.FLOWING if seen >= first else Verdict.UNANSWERED


class Viewer:
    """Signs of life of the viewer at the other end of one peer connection."""

    __slots__ = ("_asked", "_seen", "since")

    def __init__(self, now: float) -> None:
        self.since = now
        """When the viewer was connected."""
        self._seen = now
        self._asked = now

    @property
    def seen(self) -> float:
        """Time of the viewer's last sign of life."""
        return self._seen

    def alive(self, now: float) -> None:
        """Note a sign of life: RTCP, or the answer to a connectivity check, which only this viewer can have sent."""
        self._seen = now

    def gone(self, now: float) -> bool:
        """Tell whether the viewer has been silent for `SILENCE`."""
        return now - self._seen >= SILENCE

    def excuse(self, seconds: float) -> None:
        """Leave out seconds in which this process could not listen: it was stopped, or the machine slept."""
        self._seen += seconds

    def ask(self, now: float, *, urgent: bool) -> bool:
        """Tell whether to ask the viewer for a sign of life now; the request then counts as sent.

        `urgent` is for a judgement that waits for a sign; otherwise the viewer is asked after `PROBE_AFTER` of silence.
        """
        silent = now - self._seen
        due = (urgent or silent >= PROBE_AFTER) and now - self._asked >= PROBE_INTERVAL
        if due:
            self._asked = now
        return due


_WORST_FIRST = (Verdict.STALLED, Verdict.UNANSWERED, Verdict.UNDECIDED, Verdict.FLOWING)


class Arrival:
    """Progress of one receiver: the whole frames that came from an application. Suspended time does not count."""

    __slots__ = ("_opened",)

    def __init__(self) -> None:
        self._opened: float | None = None

    def opened(self, now: float) -> None:
        """Expect frames from now on."""
        self._opened = now

    def closed(self) -> None:
        """Expect no frames from now on."""
        self._opened = None

    def judge(self, now: float, last_frame_at: float | None) -> Verdict:
        """Judge whether media arrives; `last_frame_at` is when the last whole frame came, None before the first."""
        if self._opened is None:
            return Verdict.UNDECIDED
        if last_frame_at is None or last_frame_at < self._opened:
            return Verdict.UNDECIDED if now - self._opened < STALL else Verdict.STALLED
        return Verdict.FLOWING if now - last_frame_at < STALL else Verdict.STALLED


def both(verdicts: Sequence[Verdict]) -> Verdict:
    """Combine the judgements on the directions of a stream: it flows when all of them do."""
    for verdict in _WORST_FIRST:
        if verdict in verdicts:
            return verdict
    return Verdict.UNDECIDED
