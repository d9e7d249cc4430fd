"""A posture of the robot: head, body and antennas, and the matrix by which its daemon knows the head. Pure."""

from collections.abc import Sequence
from dataclasses import astuple, dataclass, fields
from math import acos, atan2, cos, hypot, isfinite, remainder, sin, tau
from typing import Final, Self

__all__ = ["ASLEEP", "NEUTRAL", "RANGES", "Posture", "angle_between", "apart", "turned_away"]


@dataclass(frozen=True, slots=True)
class Posture:
    """A posture. Angles are radians; x is ahead, y to the robot's left, z up.

    Attributes:
        roll: of the head; positive leans to the robot's right.
        pitch: of the head; positive looks down.
        yaw: of the head against the body; positive looks to the robot's left.
        x: metres of the head from its place in the neutral posture, in the axes of the body.
        y: likewise.
        z: likewise.
        body: turn of the body on its foot; positive to the robot's left.
        right: angle of the right antenna; 0 points up.
        left: of the left antenna.
    """

    roll: float = 0.0
    pitch: float = 0.0
    yaw: float = 0.0
    x: float = 0.0
    y: float = 0.0
    z: float = 0.0
    body: float = 0.0
    right: float = -0.1745
    left: float = 0.1745

    @classmethod
    def from_matrix(cls, head: Sequence[Sequence[float]], body: float, antennas: Sequence[float]) -> Self:
        """Return the posture that the daemon tells.

        Args:
            head: 4 rows of 4 numbers: the pose of the head on the robot's foot.
            body: turn of the body.
            antennas: angles of the right and the left one.

        Raises:
            ValueError: one of them is no finite number.
        """
        if not all(isfinite(number) for number in (body, *antennas, *(each for row in head for each in row))):
            raise ValueError("a posture is of finite numbers")
        roll = atan2(head[2][1], head[2][2])
        pitch = atan2(-head[2][0], hypot(head[2][1], head[2][2]))
        yaw = remainder(atan2(head[1][0], head[0][0]) - body, tau)
        ahead, left = head[0][3], head[1][3]
        x, y = ahead * cos(body) + left * sin(body), left * cos(body) - ahead * sin(body)
        return cls(roll, pitch, yaw, x, y, head[2][3], body, antennas[0], antennas[1])

    @property
    def numbers(self) -> tuple[float, ...]:
        """The nine numbers, in their order."""
        return astuple(self)

    @property
    def rotation(self) -> tuple[tuple[float, float, float], ...]:
        """The rotation of the head on the robot's foot, as three rows."""
        sr, sp, sy = sin(self.roll), sin(self.pitch), sin(self.yaw + self.body)
        cr, cp, cy = cos(self.roll), cos(self.pitch), cos(self.yaw + self.body)
        return (
            (cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr),
            (sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr),
            (-sp, cp * sr, cp * cr),
        )

    @property
    def matrix(self) -> list[float]:
        """The pose of the head on the robot's foot: 16 numbers, row by row."""
        one, two, three = self.rotation
        sin_body, cos_body = sin(self.body), cos(self.body)
        ahead, left = self.x * cos_body - self.y * sin_body, self.x * sin_body + self.y * cos_body
        return [*one, ahead, *two, left, *three, self.z, 0.0, 0.0, 0.0, 1.0]

    @property
    def antennas(self) -> list[float]:
        """The angles of the right and the left antenna."""
        return [self.right, self.left]

    def within_reach(self) -> Self:
        """Return the nearest posture that the robot can take."""
        bounded = (max(low, min(high, value)) for value, (low, high) in zip(self.numbers, RANGES, strict=True))
        return type(self)(*bounded)


RANGES: Final[tuple[tuple[float, float], ...]] = (
    (-0.5, 0.5),
    (-0.6, 0.6),
    (-1.0, 1.0),
    (-0.025, 0.025),
    (-0.025, 0.025),
    (-0.055, 0.02),
    (-2.7, 2.7),
    (-3.1, 3.1),
    (-3.1, 3.1),
)
"""Least and greatest value of each number. The daemon turns the body along where the head turns more than 1.13 rad
against it, and lets the body turn by 2.79 rad."""

NEUTRAL: Final = Posture()
"""Looks ahead, antennas up: what the daemon calls awake."""

ASLEEP: Final = Posture(pitch=0.4257, x=-0.021, z=-0.044, right=-3.05, left=3.05)
"""The head rests on the body, antennas down: what the daemon calls asleep."""

assert len(RANGES) == len(fields(Posture))


def angle_between(one: Posture, other: Posture) -> float:
    """Return the angle in radians between two rotations of the head."""
    trace = sum(a * b for rows in zip(one.rotation, other.rotation, strict=True) for a, b in zip(*rows, strict=True))
    return acos(max(-1.0, min(1.0, (trace - 1) / 2)))


def turned_away(one: Posture, other: Posture) -> float:
    """Return by how many radians head or body are turned otherwise, whichever is more."""
    return max(angle_between(one, other), abs(one.body - other.body))


def apart(one: Posture, other: Posture) -> float:
    """Return by how much two postures differ: radians of head, body or antennas, or decimetres of the head's place."""
    shift = 10 * hypot(one.x - other.x, one.y - other.y, one.z - other.z)
    return max(turned_away(one, other), shift, abs(one.right - other.right), abs(one.left - other.left))
