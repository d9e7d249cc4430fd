"""The reactions: offsets from the body at rest, as key frames.

Times are seconds. Every channel starts and ends at rest, so that any reaction may follow any other.
"""

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from typing import Final

from openrois_avatar.engines.animation.curves import Curve
from openrois_avatar.engines.animation.pose import Arm

Keys = tuple[tuple[float, float], ...]


@dataclass(frozen=True, slots=True)
class Reaction:
    """Offsets from rest by channel, over `duration` seconds."""

    duration: float
    curves: Mapping[str, Curve]

    def at(self, elapsed: float) -> dict[str, float]:
        """Return the offsets so many seconds after the start."""
        return {channel: curve(elapsed) for channel, curve in self.curves.items()}


def _reaction(duration: float, keys: Mapping[str, Keys], **arms: tuple[tuple[float, Arm], ...]) -> Reaction:
    """Return a reaction of the keys between rest at both ends; `left` and `right` are whole arms."""
    curves = {channel: Curve((0.0, 0.0), *inner, (duration, 0.0)) for channel, inner in keys.items()}
    for side, inner_arms in arms.items():
        for part in fields(Arm):
            rest = getattr(Arm(), part.name)
            inner = [(time, getattr(arm, part.name) - rest) for time, arm in inner_arms]
            if any(value for _, value in inner):
                curves[f"{side}.{part.name}"] = Curve((0.0, 0.0), *inner, (duration, 0.0))
    return Reaction(duration, curves)


def _held(value: float, start: float, end: float) -> Keys:
    return ((start, value), (end, value))


def _brows(*keys: tuple[float, float]) -> dict[str, Keys]:
    return {"brow_left": keys, "brow_right": keys}


def _lids(*keys: tuple[float, float]) -> dict[str, Keys]:
    return {"lid_left": keys, "lid_right": keys}


_RAISED = Arm(out=2.20, y=-0.50, z=-0.82, swivel=0.3, twist=0.0, curl=0.06, spread=0.9)
_WAVE_IN = replace(_RAISED, out=2.02, side=-0.32)
_WAVE_OUT = replace(_RAISED, out=2.36, z=-0.90, side=0.34)
_HIGH = Arm(out=2.02, y=-0.25, z=-0.52, swivel=0.25, twist=0.0, curl=0.08, spread=0.35)
_OFFERED = Arm(out=0.45, y=-2.25, z=-2.00, swivel=0.4, twist=-1.6, side=-0.38, curl=0.15, spread=0.1)
_AT_WATCH = Arm(out=0.02, y=-1.10, z=-2.12, swivel=-0.95, twist=0.85, bend=-0.05, curl=0.35, spread=0.1)
_OPEN_HANDS = Arm(out=2.20, y=-0.75, z=-2.40, swivel=0.9, twist=1.64, bend=0.10, curl=0.16, spread=0.6)
_APART = Arm(out=0.52, y=-1.35, z=-2.05, swivel=0.45, twist=-1.25, curl=0.08, spread=0.15)
_TOGETHER = replace(_APART, out=0.13)
_STARTLED = Arm(out=1.05, y=-1.05, z=-1.95, swivel=0.35, twist=0.15, curl=0.18, spread=0.9)

REACTIONS: Final[Mapping[str, Reaction]] = {
    "nod": _reaction(
        1.25,
        {
            "head_pitch": ((0.25, -0.24), (0.50, 0.05), (0.78, -0.17), (1.02, 0.02)),
            "mouth.smile": _held(0.35, 0.3, 0.9),
            **_brows((0.25, -0.10), (0.5, 0.25), (0.9, 0.0)),
        },
    ),
    "tilt": _reaction(
        1.9,
        {
            "head_roll": ((0.45, 0.27), (1.30, 0.25)),
            "head_yaw": ((0.45, 0.05), (1.30, 0.05)),
            "mouth.smile": _held(0.45, 0.45, 1.3),
            "brow_left": _held(0.40, 0.45, 1.3),
            "brow_right": _held(0.15, 0.45, 1.3),
            "side": _held(0.02, 0.5, 1.3),
        },
    ),
    "shake_head": _reaction(
        1.6,
        {
            "head_yaw": ((0.25, -0.30), (0.58, 0.30), (0.90, -0.24), (1.20, 0.14)),
            "gaze_yaw": ((0.25, 0.16), (0.58, -0.16), (0.90, 0.12), (1.20, -0.07)),
            "frown": _held(0.35, 0.3, 1.2),
            "mouth.smile": _held(-0.25, 0.3, 1.2),
        },
    ),
    "bow": _reaction(
        2.6,
        {
            "lean": ((0.85, 0.50), (1.40, 0.50)),
            "head_pitch": ((0.80, -0.30), (1.45, -0.30)),
            "gaze_pitch": ((0.70, -0.25), (1.45, -0.25)),
            "mouth.smile": _held(0.30, 0.5, 2.0),
            **_lids((0.80, 0.55), (1.45, 0.55)),
        },
    ),
    "shake_hands": _reaction(
        3.2,
        {
            "lean": ((0.75, 0.09), (2.30, 0.09)),
            "twist": ((0.75, 0.10), (2.30, 0.10)),
            "head_pitch": ((0.80, 0.02), (1.10, -0.07), (1.45, 0.02), (2.20, 0.0)),
            "mouth.smile": _held(0.75, 0.6, 2.4),
            "mouth.upper": _held(0.25, 0.6, 2.4),
            "squint": _held(0.45, 0.6, 2.4),
            **_brows((0.6, 0.30), (2.2, 0.15)),
        },
        right=(
            (0.85, _OFFERED),
            (1.10, replace(_OFFERED, z=-2.18)),
            (1.32, replace(_OFFERED, z=-1.86)),
            (1.56, replace(_OFFERED, z=-2.18)),
            (1.80, replace(_OFFERED, z=-1.88)),
            (2.05, replace(_OFFERED, z=-2.12)),
            (2.25, _OFFERED),
        ),
    ),
    "glance_at_watch": _reaction(
        2.9,
        {
            "head_pitch": ((0.70, -0.26), (1.75, -0.26), (2.15, 0.0)),
            "head_yaw": ((0.70, 0.13), (1.75, 0.13), (2.15, 0.0)),
            "gaze_pitch": ((0.50, -0.28), (1.70, -0.30), (1.95, 0.0)),
            "gaze_yaw": ((0.50, 0.06), (1.70, 0.06), (1.95, 0.0)),
            **_brows((0.8, 0.0), (1.2, 0.35), (1.8, 0.2)),
        },
        left=((0.75, _AT_WATCH), (1.75, _AT_WATCH)),
    ),
    "wave": _reaction(
        2.9,
        {
            "head_roll": ((0.55, -0.10), (2.10, -0.10)),
            "head_yaw": ((0.55, -0.05), (2.10, -0.05)),
            "mouth.smile": _held(1.0, 0.5, 2.2),
            "mouth.jaw": _held(0.16, 0.5, 2.1),
            "mouth.upper": _held(0.45, 0.5, 2.1),
            "squint": _held(0.55, 0.5, 2.2),
            "side": _held(-0.02, 0.6, 2.0),
            **_brows((0.5, 0.45), (2.1, 0.30)),
        },
        right=(
            (0.55, _WAVE_IN),
            (0.82, _WAVE_OUT),
            (1.08, _WAVE_IN),
            (1.34, _WAVE_OUT),
            (1.60, _WAVE_IN),
            (1.86, _WAVE_OUT),
            (2.08, _RAISED),
        ),
    ),
    "look_around": _reaction(
        3.4,
        {
            "head_yaw": ((0.60, -0.48), (1.15, -0.48), (1.85, 0.48), (2.45, 0.48)),
            "head_pitch": ((0.60, 0.05), (1.15, 0.05), (1.50, -0.03), (1.85, 0.05), (2.45, 0.05)),
            "gaze_yaw": ((0.35, -0.28), (1.10, -0.22), (1.55, 0.28), (2.40, 0.22)),
            "twist": ((0.70, -0.08), (1.15, -0.08), (1.95, 0.08), (2.45, 0.08)),
            **_brows((0.5, 0.35), (2.4, 0.35)),
            **_lids((1.20, 0.0), (1.36, 0.95), (1.55, 0.0)),
        },
    ),
    "shrug": _reaction(
        2.1,
        {
            "shoulder_left": ((0.45, 0.95), (1.20, 0.90)),
            "shoulder_right": ((0.45, 0.95), (1.20, 0.90)),
            "head_roll": ((0.50, 0.16), (1.25, 0.16)),
            "mouth.smile": _held(-0.45, 0.4, 1.2),
            "mouth.press": _held(0.35, 0.4, 1.2),
            **_brows((0.4, 0.85), (1.3, 0.75)),
        },
        left=((0.55, _OPEN_HANDS), (1.25, _OPEN_HANDS)),
        right=((0.55, _OPEN_HANDS), (1.25, _OPEN_HANDS)),
    ),
    "clap": _reaction(
        2.9,
        {
            "mouth.smile": _held(1.0, 0.5, 2.3),
            "mouth.jaw": _held(0.14, 0.6, 2.2),
            "mouth.upper": _held(0.40, 0.6, 2.2),
            "squint": _held(0.6, 0.6, 2.2),
            "head_pitch": ((0.7, 0.04), (0.95, -0.04), (1.2, 0.03), (1.5, -0.04), (1.8, 0.03), (2.1, -0.02)),
            **_brows((0.6, 0.4), (2.2, 0.3)),
        },
        **{
            side: (
                (0.60, _APART),
                *((0.78 + 0.14 * beat, _APART if beat % 2 else _TOGETHER) for beat in range(10)),
                (2.24, _APART),
            )
            for side in ("left", "right")
        },
    ),
    "raise_hand": _reaction(
        2.8,
        {
            "side": _held(0.025, 0.6, 2.1),
            "head_yaw": _held(-0.03, 0.6, 2.1),
            "mouth.smile": _held(0.30, 0.5, 2.0),
            "shoulder_right": _held(0.35, 0.6, 2.1),
            **_brows((0.5, 0.45), (2.0, 0.35)),
        },
        right=((0.65, _HIGH), (2.05, _HIGH)),
    ),
    "surprise": _reaction(
        2.0,
        {
            "wide": ((0.16, 1.0), (1.10, 0.9)),
            "head_pitch": ((0.22, 0.10), (1.10, 0.07)),
            "lean": ((0.25, -0.06), (1.10, -0.05)),
            "shoulder_left": ((0.28, 0.45), (1.10, 0.35)),
            "shoulder_right": ((0.28, 0.45), (1.10, 0.35)),
            "mouth.jaw": ((0.22, 0.62), (1.10, 0.50)),
            "mouth.round": ((0.22, 0.35), (1.10, 0.32)),
            **_brows((0.18, 1.0), (1.15, 0.95)),
        },
        left=((0.45, _STARTLED), (1.15, _STARTLED)),
        right=((0.45, _STARTLED), (1.15, _STARTLED)),
    ),
}
"""Every reaction by its name on the engine link."""
