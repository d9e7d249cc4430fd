"""Choice of a rung and a bit rate for one viewer of a video source. Pure: the time is an argument."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, Self, TypeVar

from openrois_streaming.adaptation.budget import PathBudget
from openrois_streaming.adaptation.rung import Rung

VIDEO_SHARE: Final = 0.85
"""Share of a path's budget for pictures; the rest is for headers, repetitions, and sound."""

# Moving up needs more than staying does.
_UP: Final = 1.08

# Seconds that a rung is left alone after it was too much; doubled when it was too much soon after it was entered.
_AVOID: Final = 4.0
_LONGEST_AVOID: Final = 64.0
_SOON: Final = 10.0


@dataclass(frozen=True, slots=True)
class Caps:
    """Limits of one video stream; None is no limit. A source without so small a rung gives its smallest.

    `max_bitrate` is in bit/s and covers everything sent of the stream; `width` and `height` are in pixels; `fps` is
    the pictures per second.
    """

    max_bitrate: int | None = None
    width: int | None = None
    height: int | None = None
    fps: float | None = None

    def within(self, other: Self) -> Self:
        """Return the lower of both limits in each respect."""
        return type(self)(
            _lower(self.max_bitrate, other.max_bitrate),
            _lower(self.width, other.width),
            _lower(self.height, other.height),
            _lower(self.fps, other.fps),
        )

    def admits(self, rung: Rung) -> bool:
        """Tell whether pictures of the size of `rung` are small enough."""
        return (self.width is None or rung.width <= self.width) and (self.height is None or rung.height <= self.height)


Number = TypeVar("Number", int, float)


def _lower(one: Number | None, other: Number | None) -> Number | None:
    return one if other is None else other if one is None else min(one, other)


@dataclass(frozen=True, slots=True)
class Standing:
    """Rung as one viewer can have it now."""

    rung: Rung
    least: float
    """Bit/s of video that a viewer must be able to take, to be on it."""


@dataclass(frozen=True, slots=True)
class Decision:
    """Decision on what a viewer is sent."""

    index: int
    """Index of the rung."""
    demand: float
    """Bit/s of video that the viewer can take."""
    stills: bool
    """Whether the path is too narrow even for the lowest rung, so that single pictures are sent."""


class Adaptation:
    """Adaptation of one viewer of one source.

    Args:
        caps: limits of the stream.
        now: the time.
        start: bit/s that its path was measured to carry earlier; None if unknown.
    """

    def __init__(self, caps: Caps, now: float, start: float | None = None) -> None:
        self.caps = caps
        self.path = PathBudget(now, start)
        self.index: int | None = None
        """Index of the chosen rung; None before the first choice."""
        self.switches = 0
        """Number of changes of the rung."""
        self._avoid = _AVOID
        self._avoid_until = now
        self._entered_at = now

    def decide(self, standings: Sequence[Standing], now: float) -> Decision:
        """Choose among the rungs, best first; at least one."""
        path = self.path
        allowed = [index for index, each in enumerate(standings) if self.caps.admits(each.rung)] or [len(standings) - 1]
        path.tick(self._capped(standings[allowed[0]].rung.max_bitrate / VIDEO_SHARE), now)
        bitrate = self._capped(path.budget) * VIDEO_SHARE
        index = self._choose(standings, allowed, bitrate, now)
        too_little = bitrate < standings[index].rung.min_bitrate and index == len(standings) - 1
        return Decision(index, bitrate, too_little)

    def _capped(self, bitrate: float) -> float:
        return bitrate if self.caps.max_bitrate is None else min(bitrate, self.caps.max_bitrate)

    def _choose(self, standings: Sequence[Standing], allowed: Sequence[int], bitrate: float, now: float) -> int:
        present = self.index
        if present is None or present not in allowed:
            chosen = _best(standings, allowed, bitrate)
        elif bitrate < standings[present].least:
            chosen = _best(standings, [each for each in allowed if each > present] or [present], bitrate)
            if chosen != present:
                self._avoid = min(2 * self._avoid, _LONGEST_AVOID) if now - self._entered_at < _SOON else _AVOID
                self._avoid_until = now + self._avoid
        elif now < self._avoid_until:
            chosen = present
        else:
            higher = [each for each in allowed if each < present and bitrate >= _UP * standings[each].least]
            chosen = higher[0] if higher else present
        if chosen != present:
            self.switches += present is not None
            self.index, self._entered_at = chosen, now
        return chosen


def _best(standings: Sequence[Standing], allowed: Sequence[int], bitrate: float) -> int:
    return next((each for each in allowed if bitrate >= standings[each].least), allowed[-1])
