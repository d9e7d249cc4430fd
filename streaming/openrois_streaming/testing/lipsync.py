"""Lip sync: the delay of sound behind the picture of the same moment. Pure."""

from collections import deque
from dataclasses import dataclass

from openrois_streaming.testing.delays import percentile
from openrois_streaming.testing.pictures import KEPT

_APART = 0.1
"""Seconds that the nearest picture may be away from a marker's whole second."""
_PICTURES, _WAITING = 256, 8


@dataclass(frozen=True, slots=True, kw_only=True)
class LipSyncFigures:
    """Lip sync errors since the count began; all times in seconds, above 0 if sound is late.

    Attributes:
        count: markers that had a picture.
        median: of the errors.
        p95: the value that 95 % of the errors do not exceed, either way.
        worst: the largest error, either way.
        drift: by how much the error grows, in seconds per second (least squares); 0 with fewer than three.
    """

    count: int
    median: float
    p95: float
    worst: float
    drift: float


class LipSync:
    """Pairing of markers and pictures, in any order; its memory is bounded."""

    def __init__(self) -> None:
        self._pictures: deque[tuple[float, float]] = deque(maxlen=_PICTURES)
        self._waiting: deque[tuple[float, float]] = deque(maxlen=_WAITING)
        self._errors: deque[tuple[float, float]] = deque(maxlen=KEPT)

    def restart(self) -> None:
        """Begin to count anew, without the markers played until now that still wait for a picture."""
        self._waiting.clear()
        self._errors.clear()

    def add_picture(self, captured: float, delay: float) -> None:
        """Add a picture captured at `captured` (epoch seconds) that was decoded `delay` seconds later."""
        self._pictures.append((captured, delay))
        self._settle()

    def add_sound(self, second: float, delay: float) -> None:
        """Add the marker of a whole second (epoch) that was played `delay` seconds later."""
        self._waiting.append((second, delay))
        self._settle()

    def figures(self) -> LipSyncFigures | None:
        """Return the figures; None without a marker that has a picture."""
        if not self._errors:
            return None
        signed = sorted(error for _, error in self._errors)
        either = sorted(map(abs, signed))
        return LipSyncFigures(
            count=len(signed),
            median=percentile(signed, 0.5),
            p95=percentile(either, 0.95),
            worst=either[-1],
            drift=_slope(list(self._errors)),
        )

    def _settle(self) -> None:
        """Pair the markers for which the pictures before and after have come."""
        while self._waiting and self._pictures and self._pictures[-1][0] >= self._waiting[0][0]:
            second, sound = self._waiting.popleft()
            captured, picture = min(self._pictures, key=lambda each: abs(each[0] - second))
            if abs(captured - second) <= _APART:
                self._errors.append((second, sound - picture))


def _slope(points: list[tuple[float, float]]) -> float:
    if len(points) < 3:
        return 0.0
    middle = sum(x for x, _ in points) / len(points)
    level = sum(y for _, y in points) / len(points)
    return sum((x - middle) * (y - level) for x, y in points) / sum((x - middle) ** 2 for x, _ in points)
