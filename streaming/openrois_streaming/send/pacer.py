"""The pace at which packets leave for one viewer: a large picture is spread out, and sound never waits for it.

A burst of some dozen packets overflows the queue of a home's access link, which costs sound as well as the picture.
"""

from collections import deque
from dataclasses import dataclass
from typing import Protocol

from openrois_streaming.clock import MediaClock
from openrois_streaming.encoded import EncodedFrame
from openrois_streaming.rtp.payloads import PAYLOAD_LIMIT
from openrois_streaming.send.probe import Later, Probe, Timer

FIRST_RATE = 20_000_000
"""Bit/s as long as nothing is known of the path."""

HEADROOM = 2.5
"""How many times what the path is said to carry: a picture must not take longer than until the next one."""

LEAST_RATE, MOST_RATE = 5_000_000, 100_000_000
"""Bounds of the pace in bit/s. With the lower one an ordinary picture leaves before the next one comes, however little
the path is said to carry: a pace is no limit of the bit rate."""

BURST = 20_000
"""Bytes that may leave at once, ordinary pictures whole."""

BURST_SECONDS = 0.01
"""Or as much as the pace makes of this time, where that is more."""

LONGEST_BACKLOG = 0.5
"""Seconds that pictures may wait; then they are too late, and the next key frame is waited for instead."""

SHORTEST_PAUSE = 0.001
"""Seconds between two looks; the timers of event loops are not finer."""


class Paced(Protocol):
    """A sender, as its pacer sees it."""

    def release(self, frame: EncodedFrame, first: int, end: int) -> None:
        """Send the payloads `first` to `end` of a frame, now."""
        ...

    def discard(self, frames: int, *, repair: bool) -> None:
        """So many frames are too late and will not be released; a key frame is needed if `repair`."""
        ...

    def pad(self, octets: int) -> int:
        """Send about so many bytes that nobody needs; returns how many."""
        ...


@dataclass(slots=True)
class _Waiting:
    """A frame that has to wait, from payload `next` on."""

    source: Paced
    frame: EncodedFrame
    next: int = 0


class Pacer:
    """Decides when the packets of all senders of one viewer leave. To be closed.

    Args:
        later: the event loop's `call_later`.
    """

    def __init__(self, clock: MediaClock, later: Later) -> None:
        self.octets = 0
        """Bytes that have left so far, without headers."""
        self.rate: float = FIRST_RATE
        """The pace in bit/s."""
        self._clock = clock
        self._later = later
        self._waiting: deque[_Waiting] = deque()
        self._allowance: float = BURST
        self._most = _burst(FIRST_RATE)
        self._filled = clock.now()
        self._timer: Timer | None = None
        self._probe: Probe | None = None

    @property
    def backlog(self) -> float:
        """Seconds until what waits now has left."""
        return sum(_rest(each) for each in self._waiting) * 8 / self.rate

    def estimated(self, bitrate: int) -> None:
        """The viewer says that its path carries `bitrate` (bit/s)."""
        self.rate = min(max(bitrate * HEADROOM, LEAST_RATE), MOST_RATE)
        self._most = _burst(self.rate)

    def send(self, source: Paced, frame: EncodedFrame, *, urgent: bool) -> None:
        """Have `source` release a frame as soon as the pace allows; at once if it is `urgent`."""
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
        """So many bytes leave beside those that wait."""
        self.octets += octets
        self._allowance -= octets

    def close(self) -> None:
        """Forget what waits, and pad no more."""
        self._stop_probe()
        self._waiting.clear()
        self._stop_timer()

    def probe(self, source: Paced, bitrate: int, seconds: float) -> None:
        """Have `source` pad for `seconds`, so that `bitrate` (bit/s) leaves; instead of what is padded now."""
        self._stop_probe()
        self._probe = Probe(
            bitrate, seconds, pad=source.pad, left=lambda: self.octets, now=self._clock.now, later=self._later
        )

    def _stop_probe(self) -> None:
        if self._probe is not None:
            self._probe.stop()
            self._probe = None

    def _fill(self) -> None:
        now = self._clock.now()
        self._allowance = min(self._allowance + self.rate / 8 * (now - self._filled), self._most)
        self._filled = now

    def _release(self) -> None:
        """Let go what the allowance covers, and come back for the rest."""
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
        """Drop the pictures of `source` that wait, but for one that has begun, and `frame` unless it is a key frame."""
        kept = [each for each in self._waiting if each.next or each.source is not source]
        dropped = len(self._waiting) - len(kept) + (not frame.keyframe)
        self._waiting = deque(kept)
        source.discard(dropped, repair=not frame.keyframe)


def _burst(rate: float) -> float:
    """Bytes that may leave at once with a pace of `rate`."""
    return max(BURST, rate / 8 * BURST_SECONDS)


def _rest(waiting: _Waiting) -> int:
    """Bytes that have not left."""
    return sum(map(len, waiting.frame.payloads[waiting.next :]))
