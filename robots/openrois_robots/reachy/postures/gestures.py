"""The robot's reactions, as key frames of our own: the vendor's emotions and dances are downloads. Pure."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Final

from openrois_robots.reachy.postures.posture import ASLEEP, NEUTRAL, Posture

__all__ = ["GESTURES", "SLEEPING", "WAKING", "Frame", "turned"]

WAKING: Final = "wake_up"
SLEEPING: Final = "goto_sleep"
"""The reactions that switch the motors on before them, and off after them."""


@dataclass(frozen=True, slots=True)
class Frame:
    """A posture that is reached before the next one.

    Attributes:
        posture: with the body ahead.
        hold: seconds for which it is kept.
        pace: share of the highest speeds on the way to it.
    """

    posture: Posture
    hold: float = 0.0
    pace: float = 1.0


def turned(frame: Frame, body: float) -> Frame:
    """Return a frame with the body turned."""
    return replace(frame, posture=replace(frame.posture, body=body))


def _at(hold: float = 0.0, pace: float = 1.0, **numbers: float) -> Frame:
    return Frame(Posture(**numbers), hold, pace)


_HOME: Final = Frame(NEUTRAL)
_UP, _OUT = {"right": -0.05, "left": 0.05}, {"right": -0.9, "left": 0.9}
_DOWN: Final = {"right": -2.4, "left": 2.4}

GESTURES: Final[Mapping[str, tuple[Frame, ...]]] = MappingProxyType(
    {
        "nod": (_at(pitch=0.3), _at(pitch=-0.05), _at(pitch=0.25), _HOME),
        "shake_head": (_at(yaw=0.4), _at(yaw=-0.4), _at(yaw=0.3), _at(yaw=-0.3), _HOME),
        "tilt": (_at(roll=0.35, hold=0.6), _HOME),
        "bow": (_at(pitch=0.55, x=0.01, hold=0.4, pace=0.7), Frame(NEUTRAL, pace=0.7)),
        "greet": (
            _at(roll=0.15, pitch=-0.1, **_OUT),
            _at(roll=0.15, pitch=-0.1, right=-0.1, left=0.5),
            _at(roll=-0.15, pitch=-0.1, right=-0.9, left=0.1),
            _at(roll=0.15, pitch=-0.1, right=-0.1, left=0.9),
            _at(pitch=0.25, **_UP),
            _HOME,
        ),
        "look_around": (
            _at(yaw=0.8, pitch=-0.1, hold=0.3, pace=0.8),
            _at(yaw=-0.8, pitch=-0.1, hold=0.3, pace=0.8),
            Frame(NEUTRAL, pace=0.8),
        ),
        "happy": (
            _at(roll=0.15, z=0.01, right=-0.7, left=0.2),
            _at(roll=-0.15, right=-0.2, left=0.7),
            _at(roll=0.15, z=0.01, right=-0.7, left=0.2),
            _at(roll=-0.15, right=-0.2, left=0.7),
            _HOME,
        ),
        "sad": (_at(pitch=0.4, z=-0.01, hold=1.0, pace=0.7, **_DOWN), Frame(NEUTRAL, pace=0.8)),
        "surprised": (_at(pitch=-0.3, z=0.01, hold=0.5, **_UP), _HOME),
        "listen": (_at(roll=-0.25, yaw=0.3, pitch=0.05, hold=1.0, right=-0.1, left=0.6), _HOME),
        "think": (_at(roll=0.2, pitch=-0.25, yaw=-0.4, hold=1.0, pace=0.6, right=-0.6, left=0.2), _HOME),
        WAKING: (_HOME, _at(roll=0.3), _HOME),
        SLEEPING: (Frame(ASLEEP, pace=0.6),),
    }
)
"""By their names: the frames after the neutral posture, from which each begins. All but the last end in it."""
