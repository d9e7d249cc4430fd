"""The highest speeds of a Reachy Mini in its configuration. Pure."""

from dataclasses import dataclass
from typing import Final

__all__ = ["STEP", "MotionLimits"]

STEP: Final = 0.02
"""Seconds from one target to the next; the daemon's control steps are as long."""

_SLOWEST: Final = 0.1
_HEAD, _BODY, _ANTENNAS = 1.5, 1.0, 2.4


@dataclass(frozen=True, slots=True)
class MotionLimits:
    """The highest speeds, in rad/s. The defaults are the highest that may be set.

    With these two targets that fall into one of the daemon's control steps, as a network may deliver them, turn the
    head by less than 0.1 rad; the head turns with the body.

    Attributes:
        head: of the head against the body.
        body: of the body.
        antennas: of each antenna.

    Raises:
        ValueError: one is out of bounds.
    """

    head: float = _HEAD
    body: float = _BODY
    antennas: float = _ANTENNAS

    def __post_init__(self) -> None:
        bounds = (("head", _HEAD), ("body", _BODY), ("antennas", _ANTENNAS))
        for name, most in bounds:
            value = getattr(self, name)
            if not _SLOWEST <= value <= most:
                raise ValueError(f"motion.{name} must be between {_SLOWEST:g} and {most:g} rad/s, not {value:g}")
