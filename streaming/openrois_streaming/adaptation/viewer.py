"""What one viewer of a video source is sent: which rung of its ladder, and how much. Pure: the time is an argument."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from openrois_streaming.adaptation.budget import PathBudget
from openrois_streaming.adaptation.caps import Caps
from openrois_streaming.adaptation.rung import Rung

VIDEO_SHARE: Final = 0.85
"""What of a path's budget pictures may take; the rest is for headers, repetitions, and sound."""

# Moving up needs more than staying does.
_UP: Final = 1.08

# Seconds that a rung is left alone after it was too much; doubled when it was too much soon after it was entered.
_AVOID: Final = 4.0
_LONGEST_AVOID: Final = 64.0
_SOON: Final = 10.0


@dataclass(frozen=True, slots=True)
class Standing:
    """A rung as it is for one viewer now."""

    rung: Rung
    least: float
    """Bit/s of pictures that a viewer must be able to take, to be on it."""


@dataclass(frozen=True, slots=True)
class Decision:
    """What a viewer is to be sent from now on."""

    index: int
    """Of the rung."""
    demand: float
    """Bit/s of pictures that it can take."""
    stills: bool
    """Whether not even the lowest rung gets through, so that single pictures are all it can have."""


class Adaptation:
    """Follows one viewer of one source.

    Args:
        caps: what it is given at most.
        now: the time.
        start: what its path was seen to carry earlier, in bit/s; None if nothing is known.
    """

    def __init__(self, caps: Caps, now: float, start: float | None = None) -> None:
        self.caps = caps
        self.path = PathBudget(now, start)
        self.index: int | None = None
        """The rung that was chosen; None before the first choice."""
        self.switches = 0
        """How many times another one was chosen."""
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
