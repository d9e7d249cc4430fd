"""Gestures of a head from its motion: nod, shake, tilt. Pure."""

import math
from collections import deque
from collections.abc import Sequence
from typing import Final, Literal, NamedTuple

__all__ = ["Gesture", "HeadGestures"]

Gesture = Literal["nod", "tilt", "shake_head"]

_SMALLEST: Final = 0.05
"""Face widths that a swing has at least: less is noise of the measurement."""
_LARGEST: Final = 0.7
"""Face widths that a swing has at most: more is a person that moves about."""
_SLOWEST: Final = 0.7
"""Seconds that a swing may take: slower is no gesture."""
_SWINGS: Final = 3
"""Swings to and fro that make a gesture, as down, up, down: fewer are a look elsewhere, or sitting down."""
_ACROSS: Final = 0.6
"""Limit of the motion across, as a share of the motion along: motion in between is neither nod nor shake."""
_REST: Final = 0.2
"""The share of a swing's way within which the head is still at rest before it."""
_CALM: Final = 1.0
"""Seconds between two gestures of the same kind: continuous nodding is one nod."""
_WINDOW: Final = 3.0
"""Seconds of motion in the analysis window."""
_TILTED: Final = math.radians(12)
_UPRIGHT: Final = math.radians(6)
"""A tilt begins beyond the first and is over below the second, measured from how the head is usually held."""
_HELD: Final = 0.4
"""Seconds that a tilt lasts at least."""
_HABIT: Final = 6.0
"""Seconds over which the usual tilt is learned."""


class _Sample(NamedTuple):
    moment: float
    x: float
    y: float


class _Swing(NamedTuple):
    begin: float
    end: float
    reach: float


class HeadGestures:
    """Detects the gestures of one head. A hand-held camera that moves the picture likewise counts as a gesture."""

    def __init__(self) -> None:
        self._samples: deque[_Sample] = deque()
        self._seen_at: dict[Gesture, float] = {}
        self._roll = 0.0
        self._usual = 0.0
        self._tilted_since: float | None = None
        self._told_tilt = False

    def add_motion(self, moment: float, x: float, y: float, roll: float) -> Gesture | None:
        """Add the motion since the last picture, and return the gesture that it completes.

        Args:
            moment: of the picture, in seconds.
            x: to the right, in face widths.
            y: down, in face widths.
            roll: clockwise, in radians.
        """
        last = self._samples[-1] if self._samples else _Sample(moment, 0.0, 0.0)
        self._samples.append(_Sample(moment, last.x + x, last.y + y))
        while moment - self._samples[0].moment > _WINDOW:
            self._samples.popleft()
        if self._tilts(moment, roll, moment - last.moment):
            return "tilt"
        return self._swung(moment)

    def _tilts(self, moment: float, roll: float, passed: float) -> bool:
        self._roll += roll
        leaning = abs(self._roll - self._usual)
        if self._tilted_since is None and leaning <= _TILTED:
            self._usual += (self._roll - self._usual) * min(1.0, passed / _HABIT)
        elif self._tilted_since is None:
            self._tilted_since = moment
        elif leaning < _UPRIGHT:
            self._tilted_since, self._told_tilt = None, False
        elif not self._told_tilt and moment - self._tilted_since >= _HELD:
            self._told_tilt = True
            return True
        return False

    def _swung(self, moment: float) -> Gesture | None:
        found: tuple[tuple[Gesture, list[float], list[float]], ...] = (
            ("nod", [each.y for each in self._samples], [each.x for each in self._samples]),
            ("shake_head", [each.x for each in self._samples], [each.y for each in self._samples]),
        )
        for gesture, along, across in found:
            if self._is_gesture(along, across):
                before = self._seen_at.get(gesture, -math.inf)
                self._seen_at[gesture] = moment
                if moment - before > _CALM:
                    return gesture
        return None

    def _is_gesture(self, along: Sequence[float], across: Sequence[float]) -> bool:
        moments = [each.moment for each in self._samples]
        swings = _swings(moments, along)[-_SWINGS:]
        if len(swings) < _SWINGS or moments[-1] - swings[-1].end > _SLOWEST:
            return False
        if any(each.reach > _LARGEST or each.end - each.begin > _SLOWEST for each in swings):
            return False
        begin, end = swings[0].begin, swings[-1].end
        meanwhile = [value for value, at in zip(across, moments, strict=True) if begin <= at <= end]
        return max(meanwhile) - min(meanwhile) <= _ACROSS * max(each.reach for each in swings)


def _swings(moments: Sequence[float], values: Sequence[float]) -> list[_Swing]:
    """Return the swings from turning point to turning point; the last one may go on."""
    swings: list[_Swing] = []
    start = extreme = 0
    way = 0
    for index, value in enumerate(values):
        turned = abs(value - values[extreme]) >= _SMALLEST
        if way and way * (value - values[extreme]) >= 0:
            extreme = index
        elif turned:
            if way:
                swings.append(_swing(moments, values, start, extreme))
            start, extreme, way = extreme, index, 1 if value > values[extreme] else -1
    if way:
        swings.append(_swing(moments, values, start, extreme))
    return swings


def _swing(moments: Sequence[float], values: Sequence[float], start: int, end: int) -> _Swing:
    """Return the swing between two turning points; it begins where the rest before it ends."""
    reach = abs(values[end] - values[start])
    begin = max(index for index in range(start, end + 1) if abs(values[index] - values[start]) <= _REST * reach)
    return _Swing(moments[begin], moments[end], reach)
