"""Poses and times of ROS messages. Pure."""

from collections.abc import Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from math import atan2, cos, isfinite, sin
from typing import Any, Final

__all__ = ["Heard", "image_time", "pose_message", "read_heard", "stamp_seconds", "yaw"]

OLDEST: Final = 10.0
"""Seconds that a picture may be old by its stamp; more is taken for the time of another clock."""


@dataclass(frozen=True, slots=True)
class Heard:
    """A pose as the robot has published it.

    Attributes:
        x: metres.
        y: metres.
        th: radians to the left of the x axis.
        frame: of coordinates, by the robot's name for it.
        at: epoch seconds of the robot's clock; 0: it gave no time.
    """

    x: float
    y: float
    th: float
    frame: str
    at: float

    def time(self, came_at: float) -> datetime:
        """Return when the robot was there; `came_at` (epoch seconds) where it gave no time."""
        return datetime.fromtimestamp(self.at or came_at, UTC)


def yaw(orientation: Any) -> float:
    """Return the turn about the vertical axis of a `geometry_msgs/msg/Quaternion`, in radians."""
    x, y, z, w = orientation.x, orientation.y, orientation.z, orientation.w
    return atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))


def stamp_seconds(stamp: Any) -> float:
    """Return epoch seconds of a `builtin_interfaces/msg/Time`."""
    return float(stamp.sec) + float(stamp.nanosec) * 1e-9


def read_heard(message: Any) -> Heard | None:
    """Return the pose of a message; None: it has numbers that are none.

    Args:
        message: `Odometry`, `PoseStamped` or `PoseWithCovarianceStamped`.
    """
    pose = getattr(message.pose, "pose", message.pose)
    at, turn = pose.position, yaw(pose.orientation)
    seconds = max(0.0, stamp_seconds(message.header.stamp))
    if not all(isfinite(each) for each in (at.x, at.y, turn)):
        return None
    return Heard(at.x, at.y, turn, message.header.frame_id, seconds)


def pose_message(x: float, y: float, th: float, frame: str, at: float) -> Mapping[str, Any]:
    """Return the fields of a `geometry_msgs/msg/PoseStamped`; `at` is epoch seconds."""
    sec = int(at)
    return {
        "header": {"stamp": {"sec": sec, "nanosec": int((at - sec) * 1e9)}, "frame_id": frame},
        "pose": {
            "position": {"x": float(x), "y": float(y), "z": 0.0},
            "orientation": {"x": 0.0, "y": 0.0, "z": sin(th / 2), "w": cos(th / 2)},
        },
    }


def image_time(stamp: Any, now: float, wall: float) -> float:
    """Return when a picture was taken, in seconds of the media clock.

    Args:
        stamp: of its header, by the robot's clock.
        now: of the media clock, when it came.
        wall: epoch seconds, when it came.

    Returns:
        The time of the stamp, where the robot's clock can be this machine's: no later than now, and not much before.
        Otherwise the time at which the picture came.
    """
    age = wall - stamp_seconds(stamp)
    return now - age if 0 <= age <= OLDEST else now
