"""Curves over time: eased key frames, soft steps, and critically damped springs."""

from bisect import bisect_right
from itertools import pairwise
from math import exp


def smooth(value: float) -> float:
    """Return a step from 0 to 1 over 0..1 that starts and ends without speed."""
    clipped = min(max(value, 0.0), 1.0)
    return clipped * clipped * (3.0 - 2.0 * clipped)


class Curve:
    """A smooth line through key frames (seconds, value) in order of time.

    It never overshoots a key, rests at the turning points and at both ends, and keeps the end values outside.
    """

    def __init__(self, *keys: tuple[float, float]) -> None:
        self._times = [time for time, _ in keys]
        self._values = [value for _, value in keys]
        rises = [
            (later - earlier) / (end - start)
            for start, end, earlier, later in zip(
                self._times, self._times[1:], self._values, self._values[1:], strict=False
            )
        ]
        self._slopes = [0.0, *(_slope(before, after) for before, after in pairwise(rises)), 0.0]

    @property
    def end(self) -> float:
        """The time of the last key."""
        return self._times[-1]

    def __call__(self, time: float) -> float:
        """Return the value at a time."""
        if time <= self._times[0]:
            return self._values[0]
        if time >= self._times[-1]:
            return self._values[-1]
        index = bisect_right(self._times, time) - 1
        span = self._times[index + 1] - self._times[index]
        part = (time - self._times[index]) / span
        start, end = self._values[index], self._values[index + 1]
        leave, arrive = self._slopes[index] * span, self._slopes[index + 1] * span
        return start + (end - start) * smooth(part) + _hermite(part, leave, arrive)


def _hermite(part: float, leave: float, arrive: float) -> float:
    """Return the offset from a soft step by the speeds at both ends."""
    return leave * part * (1 - part) ** 2 - arrive * part * part * (1 - part)


def _slope(before: float, after: float) -> float:
    """Return the speed at a key between two rises: none at a turning point, else small enough not to overshoot."""
    if before * after <= 0.0:
        return 0.0
    return 2.0 * before * after / (before + after)


def settling(offset: float, velocity: float, stiffness: float, elapsed: float) -> float:
    """Return the offset of a critically damped spring, `elapsed` seconds after it had this offset and velocity."""
    return (offset + (velocity + stiffness * offset) * elapsed) * exp(-stiffness * elapsed)


def settling_speed(offset: float, velocity: float, stiffness: float, elapsed: float) -> float:
    """Return the velocity of such a spring."""
    return (velocity - stiffness * (velocity + stiffness * offset) * elapsed) * exp(-stiffness * elapsed)
