"""The pose of the avatar's body at one moment: plain numbers, the same for every renderer.

Angles are radians. Positions are decimetres in body space: x to the right of the picture (the avatar's left), y away
from the viewer, z up; the origin is in the middle of the head when the avatar is at rest. `left` and `right` are the
avatar's own. Every `Arm` is written as if it were the right one; for the left arm x counts the other way.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, fields


@dataclass(frozen=True, slots=True)
class Mouth:
    """A mouth shape; every parameter is 0 at rest and 1 at its full extent. `smile` may be a little below 0."""

    jaw: float = 0.0
    wide: float = 0.0
    round: float = 0.0
    upper: float = 0.0
    lower: float = 0.0
    press: float = 0.0
    bite: float = 0.0
    tongue: float = 0.0
    smile: float = 0.0


@dataclass(frozen=True, slots=True)
class Arm:
    """The place of a wrist, and the posture of its hand.

    `out` is the distance from the middle of the body to the side. `swivel` turns the elbow outwards around the line
    from shoulder to wrist, `twist` turns the hand around the forearm (0: the palm to the viewer), `bend` closes the
    wrist towards the palm, `side` tilts the hand towards the little finger. `curl`: 0 flat .. 1 fist; `spread` fans
    the fingers.
    """

    out: float = 1.36
    y: float = 0.12
    z: float = -4.60
    swivel: float = 0.0
    twist: float = 1.2
    bend: float = 0.0
    side: float = 0.0
    curl: float = 0.30
    spread: float = 0.15


@dataclass(frozen=True, slots=True)
class Leg:
    """The angles of a leg: swing ahead at the hip, bend of the knee, and lift of the toes."""

    hip: float = 0.0
    knee: float = 0.0
    foot: float = 0.0


@dataclass(frozen=True, slots=True)
class Pose:
    """The pose at one moment.

    Positive angles: yaw to the right of the picture, pitch up, roll towards the picture's right, lean forward.
    Gaze is relative to the head. Lids: 0 open .. 1 closed. Brows: -1 low .. 1 high. Breath and shoulders: 0 .. 1.
    """

    head_yaw: float = 0.0
    head_pitch: float = 0.0
    head_roll: float = 0.0
    gaze_yaw: float = 0.0
    gaze_pitch: float = 0.0
    lid_left: float = 0.0
    lid_right: float = 0.0
    squint: float = 0.0
    wide: float = 0.0
    brow_left: float = 0.0
    brow_right: float = 0.0
    frown: float = 0.0
    breath: float = 0.0
    shoulder_left: float = 0.0
    shoulder_right: float = 0.0
    lean: float = 0.0
    twist: float = 0.0
    side: float = 0.0
    mouth: Mouth = field(default_factory=Mouth)
    left: Arm = field(default_factory=Arm)
    right: Arm = field(default_factory=Arm)
    left_leg: Leg = field(default_factory=Leg)
    right_leg: Leg = field(default_factory=Leg)


_GROUPS = ("mouth", "left", "right", "left_leg", "right_leg")
_OWN = tuple(part.name for part in fields(Pose) if part.name not in _GROUPS)
_MOUTH = tuple(part.name for part in fields(Mouth))
_ARM = tuple(part.name for part in fields(Arm))
_LEG = tuple(part.name for part in fields(Leg))


def channels(pose: Pose) -> dict[str, float]:
    """Return a pose's numbers by channel."""
    flat = {name: getattr(pose, name) for name in _OWN}
    groups = {"mouth": _MOUTH, "left": _ARM, "right": _ARM, "left_leg": _LEG, "right_leg": _LEG}
    for group, names in groups.items():
        part = getattr(pose, group)
        flat.update({f"{group}.{name}": getattr(part, name) for name in names})
    return flat


def from_channels(values: Mapping[str, float]) -> Pose:
    """Return the pose with these numbers.

    Raises:
        KeyError: a channel is missing.
    """
    return Pose(
        **{name: values[name] for name in _OWN},
        mouth=Mouth(*(values[f"mouth.{name}"] for name in _MOUTH)),
        left=Arm(*(values[f"left.{name}"] for name in _ARM)),
        right=Arm(*(values[f"right.{name}"] for name in _ARM)),
        left_leg=Leg(*(values[f"left_leg.{name}"] for name in _LEG)),
        right_leg=Leg(*(values[f"right_leg.{name}"] for name in _LEG)),
    )
