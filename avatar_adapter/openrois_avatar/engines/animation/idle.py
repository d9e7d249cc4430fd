"""Idle motion of the body: breathing, blinking, small movements of eyes and head.

Everything is a function of time and a seed. Random choices are made per slot of time, so no history is kept.
"""

from dataclasses import dataclass
from functools import lru_cache
from math import pi, sin
from typing import Final

import numpy as np

from openrois_avatar.engines.animation.curves import smooth

_BREATH: Final = 4.3
"""Seconds per breath."""
_BLINK_SLOT: Final = 3.6
"""Seconds of a slot, each with one blink at random."""
_CLOSING, _CLOSED, _OPENING = 0.075, 0.045, 0.170
BLINK: Final = _CLOSING + _CLOSED + _OPENING
"""Seconds a blink takes."""
_GAZE_SLOT: Final = 0.85
_SACCADE: Final = 0.055
"""Seconds a small movement of the eyes takes."""


@dataclass(frozen=True, slots=True)
class Drift:
    """Slow movement of the head (radians) and the spine."""

    yaw: float
    pitch: float
    roll: float
    side: float


def breath(time: float) -> float:
    """Return how full the chest is, 0..1; breathing in is quicker than out."""
    phase = (time / _BREATH) % 1.0
    return smooth(phase / 0.42) if phase < 0.42 else 1 - smooth((phase - 0.42) / 0.58)


def blink_at(since: float) -> float:
    """Return how closed the lids are, 0..1, `since` seconds after a blink began."""
    return smooth(since / _CLOSING) - smooth((since - _CLOSING - _CLOSED) / _OPENING)


def blink(time: float, seed: int) -> float:
    """Return how closed the lids are, 0..1: irregular blinks, now and then a double one."""
    slot = int(time // _BLINK_SLOT)
    return max(blink_at(time - slot * _BLINK_SLOT - start) for start in _blinks(slot, seed))


@lru_cache(maxsize=64)
def _blinks(slot: int, seed: int) -> tuple[float, ...]:
    """Return when the blinks of a slot start; the last of them ends within it."""
    random = _chance(1, seed, slot)
    start = random.uniform(0.2, _BLINK_SLOT - BLINK * 2.4)
    return (start, start + BLINK * 1.15) if random.random() < 0.12 else (start,)


def glance(time: float, seed: int) -> tuple[float, float]:
    """Return small movements of the eyes around their target: yaw and pitch in radians."""
    slot = int(time // _GAZE_SLOT)
    start, yaw, pitch = _fixation(slot, seed)
    _, before_yaw, before_pitch = _fixation(slot - 1, seed)
    share = smooth((time - slot * _GAZE_SLOT - start) / _SACCADE)
    return before_yaw + (yaw - before_yaw) * share, before_pitch + (pitch - before_pitch) * share


@lru_cache(maxsize=64)
def _fixation(slot: int, seed: int) -> tuple[float, float, float]:
    random = _chance(2, seed, slot)
    start = random.uniform(0.0, _GAZE_SLOT - _SACCADE)
    if random.random() < 0.45:
        return start, 0.0, 0.0
    reach = 0.085 if random.random() < 0.12 else 0.022
    return start, random.uniform(-reach, reach), random.uniform(-reach, reach) * 0.6


def drift(time: float, seed: int) -> Drift:
    """Return the slow sway of head and body; the periods never line up."""
    shift = _shift(seed)

    def wave(period: float, phase: float) -> float:
        return sin(2 * pi * (time + shift) / period + phase)

    return Drift(
        yaw=0.026 * wave(7.3, 0.0) + 0.014 * wave(3.1, 1.0),
        pitch=0.012 * wave(5.9, 2.0) + 0.007 * wave(2.7, 0.5),
        roll=0.016 * wave(8.9, 4.0) + 0.008 * wave(4.1, 2.2),
        side=0.007 * wave(11.3, 3.0),
    )


@lru_cache(maxsize=8)
def _shift(seed: int) -> float:
    return _chance(3, seed, 0).uniform(0, 100)


def _chance(kind: int, seed: int, slot: int) -> np.random.Generator:
    return np.random.default_rng((kind, seed, slot & 0xFFFFFFFF))
