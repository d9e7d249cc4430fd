"""Ladder of sizes, paces and bit rates that one video source is encoded in, best first. Pure."""

from dataclasses import dataclass
from typing import Final

MIN_BITRATE: Final = 50_000
"""Least bit rate of the lowest rung of a ladder, in bit/s."""

MAX_BITRATE: Final = 12_000_000
"""Greatest bit rate of any rung, in bit/s."""

# 720p at 30 pictures a second looks like its source with this. A picture with a quarter of the pixels has more detail
# in each, and one that follows sooner differs less from the one before: neither grows in proportion.
_REFERENCE_BITRATE: Final = 2_500_000
_REFERENCE_PIXELS: Final = 1280 * 720
_REFERENCE_RATE: Final = 30.0
_PIXELS_EXPONENT: Final = 0.75
_RATE_EXPONENT: Final = 0.6
_LEAST_MAXIMUM: Final = 200_000

# Of a rung's highest bit rate. Half the width and height takes 0.35 of it: the ranges of two neighbours overlap.
_LOWEST_SHARE: Final = 0.28

_SHORTEST_SIDE: Final = 180
_MOST_RUNGS: Final = 4
_MOST_SKIPPED: Final = 8


@dataclass(frozen=True, slots=True)
class Rung:
    """Size and pace of a source, and the range of bit rates (bit/s) for it.

    The size is the source's, halved `halvings` times; of `every` pictures one is encoded.
    """

    width: int
    height: int
    frame_rate: float
    min_bitrate: int
    max_bitrate: int
    halvings: int = 0
    every: int = 1


def ladder(
    width: int, height: int, frame_rate: float, *, every: int = 1, max_bitrate: int | None = None
) -> tuple[Rung, ...]:
    """Return the rungs of a source of `width` x `height` pixels, with every `every`-th of its pictures.

    `frame_rate` is the source's, in pictures a second. There is always one rung, and no further one whose shorter side
    would have less than 180 pixels. None has more than `max_bitrate` (bit/s).
    """
    count = 1
    while count < _MOST_RUNGS and min(width, height) >> count >= _SHORTEST_SIDE:
        count += 1
    limit = MAX_BITRATE if max_bitrate is None else max(MIN_BITRATE, min(max_bitrate, MAX_BITRATE))
    return tuple(_rung(width, height, frame_rate, every, limit, k, lowest=k == count - 1) for k in range(count))


def every_for(frame_rate: float, wanted: float | None) -> int:
    """Return n, at most 8, such that every n-th of `frame_rate` pictures a second makes no more than `wanted`."""
    if wanted is None:
        return 1
    for every in range(1, _MOST_SKIPPED):
        # A camera of 29.97 gives 30.
        if frame_rate / every <= wanted * 1.01:
            return every
    return _MOST_SKIPPED


def _rung(width: int, height: int, frame_rate: float, every: int, limit: int, halvings: int, *, lowest: bool) -> Rung:
    size, pace = (width >> halvings & ~1, height >> halvings & ~1), frame_rate / every
    most = _REFERENCE_BITRATE
    most *= (size[0] * size[1] / _REFERENCE_PIXELS) ** _PIXELS_EXPONENT * (pace / _REFERENCE_RATE) ** _RATE_EXPONENT
    most = round(min(max(_LEAST_MAXIMUM, most), limit))
    least = MIN_BITRATE if lowest else round(most * _LOWEST_SHARE)
    return Rung(*size, pace, least, most, halvings, every)


class Thinning:
    """Selection of `frame_rate` pictures a second, as evenly as the source's pace allows."""

    __slots__ = ("_due", "_interval")

    def __init__(self, frame_rate: float) -> None:
        self._interval = 1 / frame_rate
        self._due = float("-inf")

    def wants(self, captured_at: float) -> bool:
        """Tell whether the picture of this moment (seconds) is selected."""
        # A camera is never exactly in time: a picture that comes a little early is the expected one.
        if captured_at < self._due - self._interval / 4:
            return False
        self._due += self._interval
        if self._due <= captured_at:
            self._due = captured_at + self._interval
        return True
