"""SystemInformation: the posture of the robot, and what its daemon tells of itself (component 1)."""

from datetime import UTC, datetime
from typing import Final

from openrois_streaming.clock import MediaClock, wall_at

from openrois.adapter import ComponentFailed, Payload, query
from openrois_robots.components.system_information import Pose, PoseInformation
from openrois_robots.reachy.robot import Reachy

__all__ = ["FRAME", "SystemInformation"]

FRAME: Final = "foot"
"""Frame of all poses: the robot's own foot. It does not know where that stands."""


class PostureResult(Payload):
    """The posture in radians and metres, in the frame of the robot's foot, and when the robot told it.

    The head's yaw is that on the foot, the body's included; `antennas` are the right and the left one.
    """

    head_position: tuple[float, ...]
    head_roll: float
    head_pitch: float
    head_yaw: float
    body_yaw: float
    antennas: tuple[float, ...]
    frame: str
    timestamp: datetime


class DaemonResult(Payload):
    """The daemon: the robot's name, its version, the mode of the motors, and why nothing is heard, if so."""

    robot_name: str
    version: str
    motor_mode: str
    sound_problem: str


class SystemInformation(PoseInformation, function="sensing"):
    """Reports the robot's status and posture. Its pose is the turn of its body; the daemon knows of no battery.

    Args:
        robot_ref: the id by which the robot is known.
        robot: the robot.
        clock: the media clock.
    """

    def __init__(self, robot_ref: str, robot: Reachy, clock: MediaClock) -> None:
        self._robot = robot
        self._clock = clock
        super().__init__(robot_ref, robot.motion_status, robot.motion_problem, self._turn, clock.wall)

    @query
    async def posture(self) -> PostureResult:
        """Return how head, body and antennas are.

        Raises:
            ComponentFailed: the robot has not told it.
        """
        seen = self._robot.seen
        if seen is None:
            raise ComponentFailed(self._robot.link.problem)
        posture, matrix = seen.posture, seen.posture.matrix
        return PostureResult(
            head_position=(matrix[3], matrix[7], matrix[11]),
            head_roll=posture.roll,
            head_pitch=posture.pitch,
            head_yaw=posture.yaw + posture.body,
            body_yaw=posture.body,
            antennas=tuple(posture.antennas),
            frame=FRAME,
            timestamp=self._moment(seen.at),
        )

    @query
    async def daemon(self) -> DaemonResult:
        """Return what the daemon told of itself last.

        Raises:
            ComponentFailed: the robot is not linked.
        """
        if not self._robot.link.is_up:
            raise ComponentFailed(self._robot.link.problem)
        told = self._robot.told
        return DaemonResult(
            robot_name=told.name,
            version=told.version,
            motor_mode=told.motors,
            sound_problem=told.sound_problem,
        )

    def _turn(self) -> Pose | None:
        seen = self._robot.seen
        return None if seen is None else Pose(0.0, 0.0, seen.posture.body, FRAME, self._moment(seen.at))

    def _moment(self, at: float) -> datetime:
        return datetime.fromtimestamp(wall_at(self._clock, at), UTC)
