"""Gaze: the eyes jump to a target, the head follows, and the eyes turn back in it."""

from dataclasses import dataclass
from typing import Final

from openrois_avatar.engines.animation.curves import settling, settling_speed
from openrois_avatar.engines.animation.idle import BLINK, blink_at

_YAW, _PITCH = 0.62, 0.40
"""Where x = 1 and y = 1 are, in radians."""
_HEAD_SHARE: Final = 0.55
_EYE_STIFFNESS, _HEAD_STIFFNESS = 32.0, 5.5
_BLINK_FROM: Final = 0.30
"""A change of gaze by so many radians or more comes with a blink."""


@dataclass(frozen=True, slots=True)
class _Turn:
    """A motion towards a target, from an offset with a speed, since a time."""

    start: float = 0.0
    target: float = 0.0
    offset: float = 0.0
    speed: float = 0.0

    def at(self, time: float, stiffness: float) -> float:
        return self.target + settling(self.offset, self.speed, stiffness, max(0.0, time - self.start))

    def redirected(self, time: float, target: float, stiffness: float) -> "_Turn":
        speed = settling_speed(self.offset, self.speed, stiffness, max(0.0, time - self.start))
        return _Turn(time, target, self.at(time, stiffness) - target, speed)


@dataclass(frozen=True, slots=True)
class HeadAndEyes:
    """Head and eyes (relative to the head) in radians, and how closed the lids are for the change."""

    head_yaw: float
    head_pitch: float
    eye_yaw: float
    eye_pitch: float
    lid: float


class Gaze:
    """The gaze, which follows `look` commands."""

    def __init__(self) -> None:
        self._eyes = (_Turn(), _Turn())
        self._head = (_Turn(), _Turn())
        self._blink = float("-inf")

    def turn_to(self, time: float, x: float, y: float) -> None:
        """Turn the gaze from this time on to x (-1: the picture's left .. 1) and y (-1: down .. 1)."""
        targets = (x * _YAW, y * _PITCH)
        far = any(abs(target - turn.target) >= _BLINK_FROM for target, turn in zip(targets, self._eyes, strict=True))
        if far and time >= self._blink + BLINK:
            self._blink = time
        yaw, pitch = targets
        self._eyes = (
            self._eyes[0].redirected(time, yaw, _EYE_STIFFNESS),
            self._eyes[1].redirected(time, pitch, _EYE_STIFFNESS),
        )
        self._head = (
            self._head[0].redirected(time, yaw * _HEAD_SHARE, _HEAD_STIFFNESS),
            self._head[1].redirected(time, pitch * _HEAD_SHARE, _HEAD_STIFFNESS),
        )

    def at(self, time: float) -> HeadAndEyes:
        """Return the angles of head and eyes at a time, not before that of the last `turn_to`."""
        head_yaw, head_pitch = (turn.at(time, _HEAD_STIFFNESS) for turn in self._head)
        eye_yaw, eye_pitch = (turn.at(time, _EYE_STIFFNESS) for turn in self._eyes)
        return HeadAndEyes(
            head_yaw, head_pitch, eye_yaw - head_yaw, eye_pitch - head_pitch, blink_at(time - self._blink)
        )
