"""Pacing of one viewer's packets: a large picture is spread out, and sound never waits for it.

A burst of some dozen packets overflows the queue of a home's access link, which costs sound as well as the picture.
"""

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol, Self, TypeAlias

from openrois_streaming.clock import MediaClock
from openrois_streaming.encoded import EncodedFrame
from openrois_streaming.rtp.payloads import PAYLOAD_LIMIT

FIRST_RATE = 20_000_000
"""Bit/s before the first estimate of the path."""

HEADROOM = 2.5
"""Factor on the estimate of the path: a picture must not take longer than until the next one."""

LEAST_RATE, MOST_RATE = 5_000_000, 100_000_000
"""Bounds of the pace in bit/s. With the lower one an ordinary picture leaves before the next one comes, however low the
estimate: a pace is no limit of the bit rate."""

BURST = 20_000
"""Bytes that may leave at once, so that ordinary pictures leave whole."""

BURST_SECONDS = 0.01
"""Or the bytes of this time at the pace, if that is more."""

LONGEST_BACKLOG = 0.5
"""Seconds that pictures may wait; later ones are dropped up to the next key frame."""

SHORTEST_PAUSE = 0.001
"""Least seconds between two releases; the timers of event loops are not finer."""


class Timer(Protocol):
    """Pending call."""

    def cancel(self) -> None:
        """Cancel the call."""
        ...


Later: TypeAlias = Callable[[float, Callable[[], None]], Timer]
"""Calls a function after so many seconds, as the event loop's `call_later` does."""


class Paced(Protocol):
    """Sender whose frames are paced."""

    def release(self, frame: EncodedFrame, first: int, end: int) -> None:
        """Send the payloads `first` to `end` of a frame now."""
        ...

    def discard(self, frames: int, *, repair: bool) -> None:
        """Note that so many frames were dropped as too late; a key frame is needed if `repair`."""
        ...


@dataclass(slots=True)
class _Waiting:
    """Frame that waits, from payload `next` on."""

    source: Paced
    frame: EncodedFrame
    next: int = 0


class Pacer:
    """Pacer of all senders of one viewer. To be closed.

    Args:
        later: the event loop's `call_later`.
    """

    def __init__(self, clock: MediaClock, later: Later) -> None:
        self.rate: float = FIRST_RATE
        """The pace in bit/s."""
        self._clock = clock
        self._later = later
        self._waiting: deque[_Waiting] = deque()
        self._allowance: float = BURST
        self._most = _burst(FIRST_RATE)
        self._filled = clock.now()
        self._timer: Timer | None = None

    @property
    def backlog(self) -> float:
        """Seconds until the waiting frames have left."""
        return sum(_rest(each) for each in self._waiting) * 8 / self.rate

    def estimated(self, bitrate: int) -> None:
        """Apply the viewer's estimate of its path, in bit/s."""
        self.rate = min(max(bitrate * HEADROOM, LEAST_RATE), MOST_RATE)
        self._most = _burst(self.rate)

    def send(self, source: Paced, frame: EncodedFrame, *, urgent: bool) -> None:
        """Let `source` release a frame as soon as the pace allows; at once if it is `urgent`."""
        octets = len(frame.data)
        self._fill()
        if urgent or (not self._waiting and octets <= self._allowance):
            self.spend(octets)
            source.release(frame, 0, len(frame.payloads))
            return
        if self.backlog > LONGEST_BACKLOG:
            self._drop_late(source, frame)
            if not frame.keyframe:
                return
        self._waiting.append(_Waiting(source, frame))
        self._release()

    def spend(self, octets: int) -> None:
        """Charge bytes that leave besides the waiting ones."""
        self._allowance -= octets

    def close(self) -> None:
        """Drop the waiting frames."""
        self._waiting.clear()
        self._stop_timer()

    def _fill(self) -> None:
        now = self._clock.now()
        self._allowance = min(self._allowance + self.rate / 8 * (now - self._filled), self._most)
        self._filled = now

    def _release(self) -> None:
        """Release what the allowance covers, and set the timer for the rest."""
        self._stop_timer()
        while self._waiting and self._allowance >= PAYLOAD_LIMIT:
            self._release_some(self._waiting[0])
        if self._waiting:
            missing = (2 * PAYLOAD_LIMIT - self._allowance) * 8 / self.rate
            self._timer = self._later(max(missing, SHORTEST_PAUSE), self._wake)

    def _release_some(self, waiting: _Waiting) -> None:
        payloads, first = waiting.frame.payloads, waiting.next
        waiting.next = min(first + int(self._allowance // PAYLOAD_LIMIT), len(payloads))
        if waiting.next == len(payloads):
            self._waiting.popleft()
        self.spend(sum(map(len, payloads[first : waiting.next])))
        waiting.source.release(waiting.frame, first, waiting.next)

    def _wake(self) -> None:
        self._timer = None
        self._fill()
        self._release()

    def _stop_timer(self) -> None:
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None

    def _drop_late(self, source: Paced, frame: EncodedFrame) -> None:
        """Drop the waiting pictures of `source`, but for one that has begun, and `frame` unless it is a key frame."""
        kept = [each for each in self._waiting if each.next or each.source is not source]
        dropped = len(self._waiting) - len(kept) + (not frame.keyframe)
        self._waiting = deque(kept)
        source.discard(dropped, repair=not frame.keyframe)


def _burst(rate: float) -> float:
    """Return the bytes that may leave at once with a pace of `rate`."""
    return max(BURST, rate / 8 * BURST_SECONDS)


def _rest(waiting: _Waiting) -> int:
    """Return the bytes that have not left."""
    return sum(map(len, waiting.frame.payloads[waiting.next :]))


SILENCE = 30.0
"""Seconds without sound after which pictures are not synchronised with it; longer than a pause between words."""


@dataclass(slots=True)
class Outlet:
    """Outlet of one viewer: clock and pace that its senders share.

    `wall_offset` is the time of day (epoch seconds) at which the media clock was 0, the same for all senders of a
    viewer, by which the viewer synchronises pictures and sound.
    """

    clock: MediaClock
    wall_offset: float
    pacer: Pacer
    sound_at: float = float("-inf")
    """Time of the last packet of sound, on the media clock."""

    @classmethod
    def made(cls, clock: MediaClock, wall_offset: float, later: Later) -> Self:
        """Return an outlet with a pacer of its own; `later` is the event loop's `call_later`."""
        return cls(clock, wall_offset, Pacer(clock, later))

    def sounds(self, now: float) -> bool:
        """Tell whether present pictures are to be synchronised with sound."""
        return now - self.sound_at < SILENCE
