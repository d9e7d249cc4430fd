"""What a viewer is given at most, whatever its path carries. Pure."""

from dataclasses import dataclass
from typing import Self, TypeVar

from openrois_streaming.adaptation.rung import Rung


@dataclass(frozen=True, slots=True)
class Caps:
    """Limits of one video stream; None is no limit. A source that has nothing as small gives the smallest it has.

    `max_bitrate` is in bit/s and covers all that is sent of the stream; `width` and `height` are in pixels; `fps` is
    the pictures per second.
    """

    max_bitrate: int | None = None
    width: int | None = None
    height: int | None = None
    fps: float | None = None

    def within(self, other: Self) -> Self:
        """Both limits at once: in each the lower one."""
        return type(self)(
            _lower(self.max_bitrate, other.max_bitrate),
            _lower(self.width, other.width),
            _lower(self.height, other.height),
            _lower(self.fps, other.fps),
        )

    def admits(self, rung: Rung) -> bool:
        """Whether pictures of the size of `rung` are small enough."""
        return (self.width is None or rung.width <= self.width) and (self.height is None or rung.height <= self.height)


Number = TypeVar("Number", int, float)


def _lower(one: Number | None, other: Number | None) -> Number | None:
    return one if other is None else other if one is None else min(one, other)
