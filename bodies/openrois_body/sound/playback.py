"""A speech in the body's sound: what comes while it is played is appended, and what is missing is silence."""

import asyncio
from collections import deque
from dataclasses import dataclass
from typing import Final, Protocol

import numpy as np
from numpy.typing import NDArray
from openrois_streaming.clock import MediaClock
from openrois_streaming.source.source import SAMPLE_RATE

from openrois_body.sound.engine_sound import SEAM

__all__ = ["AHEAD_LIMIT", "Playback", "SoundOverrun", "Timeline", "reach"]

AHEAD_LIMIT: Final = 60.0
"""Seconds of sound that may wait in one speech."""
_ROUNDED: Final = SAMPLE_RATE // 1000
"""Samples behind the last one that are still the end."""
_REMEMBERED: Final = 5 * SAMPLE_RATE
"""Samples for which it is known what was played: much longer than the way to any viewer that is waited for."""
_RISE: Final = (np.arange(SEAM, dtype=np.float32) + 0.5) / SEAM
_FALL: Final = 1 - _RISE

Samples = NDArray[np.int16]


class SoundOverrun(ValueError):
    """More sound came than may wait."""


class Timeline(Protocol):
    """The grid of samples that a speech lies on; `openrois_body.sound.mixer.BodySound` implements it."""

    def next_sample(self) -> int:
        """Return the number of the first sample that is not handed out yet."""
        ...

    def earliest(self) -> int:
        """Return the number of the first sample of a speech that begins as soon as it may."""
        ...


@dataclass(slots=True)
class _Run:
    """Sound without a gap: `count` samples of the speech from `position` on, the first of which is number `first`."""

    first: int
    position: int
    count: int = 0

    @property
    def end(self) -> int:
        return self.first + self.count


class Playback:
    """A speech with its place in time, whose sound may still be coming. Times are seconds of the media clock.

    Sound lies behind the sound before it. Where that was handed out already there is silence, and the new sound begins
    as soon as a speech may begin. Before a gap the sound fades out within 5 ms, after it the sound fades in.

    Args:
        timeline: of the body's sound.
        first: number of the first sample that it may have.
    """

    def __init__(self, timeline: Timeline, first: int) -> None:
        self._timeline = timeline
        self._first = first
        self._parts: deque[tuple[int, Samples]] = deque()
        """What is not handed out yet, each with the number of its first sample."""
        self._runs: deque[_Run] = deque()
        self._pushed = 0
        self._tail = 0
        """The last sample."""
        self._cut: int | None = None
        self._finished = False
        self._stopped = False

    @property
    def pushed(self) -> int:
        """The number of samples that have come."""
        return self._pushed

    @property
    def end(self) -> float | None:
        """When the last sample that has come has been due; None before the first one."""
        return self._runs[-1].end / SAMPLE_RATE if self._runs else None

    @property
    def is_stopped(self) -> bool:
        """Whether it was stopped."""
        return self._stopped

    @property
    def is_settled(self) -> bool:
        """Whether its end is known."""
        return self._finished or self._cut is not None

    @property
    def last(self) -> int:
        """The number of the sample after its last one, as far as that has come."""
        end = self._runs[-1].end if self._runs else self._first
        if self._cut is None:
            return end
        return min(end, self._cut + SEAM) if self._runs and self._cut > self._runs[0].first else self._first

    @property
    def heard(self) -> int:
        """The number of samples that are heard, up to `stop`; those of the fade-out do not count."""
        return self._pushed if self._cut is None else self.position(self._cut)

    @property
    def played(self) -> int:
        """The number of samples that were handed out, or will not be after `stop`."""
        return min(self.heard, self.position(self._timeline.next_sample()))

    def is_over(self, begin: int) -> bool:
        """Tell whether nothing of it is heard from sample `begin` on, and nothing will be."""
        return self.is_settled and self.last + SEAM <= begin

    def push(self, samples: Samples) -> float:
        """Append sound (mono, 48 kHz); returns when its first sample is due.

        Raises:
            SoundOverrun: more than `AHEAD_LIMIT` waits, and nothing was appended.
            ValueError: there is no sound in it, or the end was set already.
        """
        if self.is_settled or not len(samples):
            raise ValueError("sound is appended before finish or stop, one sample of it at least")
        if self._pushed - self.played + len(samples) > AHEAD_LIMIT * SAMPLE_RATE:
            raise SoundOverrun(
                f"more than {AHEAD_LIMIT:g} seconds of sound wait to be played; wait before you push more"
            )
        begin = self._timeline.next_sample()
        self._drop_before(begin)
        if not self._runs or self._runs[-1].end < begin:
            self._runs.append(_Run(max(self._timeline.earliest(), self._first), self._pushed))
            samples = _faded_in(samples)
        run = self._runs[-1]
        first = run.end
        self._parts.append((first, samples))
        run.count += len(samples)
        self._pushed += len(samples)
        self._tail = int(samples[-1])
        return first / SAMPLE_RATE

    def finish(self) -> None:
        """Set the end: behind the last sample that has come."""
        self._finished = True

    def stop(self) -> None:
        """Fade out within the next 5 ms that are not handed out yet; without effect after the end."""
        cut = self._timeline.next_sample()
        if self._cut is None and (not self._finished or cut < self.last):
            self._cut = cut
        self._stopped = True

    def take_rest(self) -> Samples:
        """Return what was not heard because of `stop`."""
        if self._cut is None:
            return np.zeros(0, np.int16)
        cut = self._cut
        rest = [part[max(0, cut - first) :] for first, part in self._parts if first + len(part) > cut]
        return np.concatenate(rest) if rest else np.zeros(0, np.int16)

    def moment(self, position: int) -> float | None:
        """Return when a sample of the speech is due, or was; None for one that has not come or is long gone.

        Behind the last sample is the end, once that is set: what is marked there is a sample or two off by rounding.
        """
        if self._finished and self._pushed <= position <= self._pushed + _ROUNDED:
            return self.end
        for run in reversed(self._runs):
            if run.position <= position < run.position + run.count:
                return (run.first + position - run.position) / SAMPLE_RATE
        return None

    def position(self, number: int) -> int:
        """Return how many of its samples lie before sample `number` of the timeline."""
        before = 0 if not self._runs else self._runs[0].position
        for run in self._runs:
            if number <= run.first:
                break
            before = run.position + min(run.count, number - run.first)
        return before

    def mix_into(self, mixed: NDArray[np.int32], begin: int) -> None:
        """Add the samples from `begin` on to `mixed`, shape (n, channels), and drop those before."""
        self._drop_before(begin)
        end = begin + len(mixed)
        own = np.zeros(len(mixed), np.int32)
        for first, part in self._parts:
            if first >= end:
                break
            since, until = max(first, begin), min(first + len(part), end)
            own[since - begin : until - begin] = part[since - first : until - first]
        self._fade_out(own, begin)
        if self._cut is not None:
            _fall_from(own, self._cut - begin)
        mixed += own[:, np.newaxis]

    def _fade_out(self, own: NDArray[np.int32], begin: int) -> None:
        """Let the last sample die away where nothing has come behind it."""
        if not self._runs:
            return
        since = self._runs[-1].end - begin
        if -SEAM < since < len(own):
            gone = max(0, -since)
            dying = np.rint(self._tail * _FALL[gone:]).astype(np.int32)[: len(own) - max(0, since)]
            own[max(0, since) : max(0, since) + len(dying)] += dying

    def _drop_before(self, begin: int) -> None:
        # What `stop` has cut off is kept: it is the rest.
        until = begin if self._cut is None else min(begin, self._cut)
        while self._parts and self._parts[0][0] + len(self._parts[0][1]) <= until:
            self._parts.popleft()
        while len(self._runs) > 1 and self._runs[1].end < begin - _REMEMBERED:
            self._runs.popleft()


async def reach(clock: MediaClock, moment: float, stopped: asyncio.Event) -> bool:
    """Wait until a moment of a clock; returns False if `stopped` is set, before or by then."""
    waiting = asyncio.create_task(clock.sleep_until(moment)), asyncio.create_task(stopped.wait())
    try:
        await asyncio.wait(waiting, return_when=asyncio.FIRST_COMPLETED)
    finally:
        for task in waiting:
            task.cancel()
    return not stopped.is_set()


def _faded_in(samples: Samples) -> Samples:
    seam = min(SEAM, len(samples))
    begun = samples.copy()
    begun[:seam] = np.rint(samples[:seam] * _RISE[:seam])
    return begun


def _fall_from(own: NDArray[np.int32], cut: int) -> None:
    """Fade out from index `cut` on, which may lie before this block or behind it."""
    fading = own[max(0, cut) :]
    gone = max(0, -cut)
    factors = np.zeros(len(fading), np.float32)
    fall = _FALL[gone : gone + len(fading)]
    factors[: len(fall)] = fall
    fading[:] = fading * factors
