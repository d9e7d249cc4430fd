"""SystemInformation of a robot: its pose, status and battery (component 1 of the standard, and queries of our own)."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from datetime import UTC, datetime

from openrois.adapter import ComponentFailed, ComponentStatus, Payload, components, query
from openrois.catalog.system_information import EngineStatusResult, RobotPositionResult
from openrois_robots.adapter.battery import Battery

__all__ = ["Pose", "PoseInformation", "SystemInformation"]


@dataclass(frozen=True, slots=True)
class Pose:
    """A pose of the robot on its floor.

    Attributes:
        x: metres.
        y: metres.
        th: radians from the x axis, to the left.
        frame: of coordinates, by the robot's own name for it.
        at: when the robot was there.
    """

    x: float
    y: float
    th: float
    frame: str
    at: datetime


class PoseResult(Payload):
    """Where the robot is, in metres and radians, in which frame of coordinates, and when it was there."""

    x: float
    y: float
    th: float
    frame: str
    timestamp: datetime


class BatteryResult(Payload):
    """The battery: its charge in per cent, whether it is charged now, and whether only the charger is a goal."""

    percent: int
    is_charging: bool
    is_low: bool


class PoseInformation(components.SystemInformation, function="sensing"):
    """Reports the robot's pose and its status: what there is to tell of a robot without a battery.

    Args:
        robot_ref: the id by which the robot is known, the only entry of `robot_ref`.
        robot_status: returns the status of the robot.
        problem: returns why it is not READY; empty: no more is known.
        pose: returns the robot's last pose; None while it has told none.
        wall_clock: epoch seconds.
    """

    def __init__(
        self,
        robot_ref: str,
        robot_status: Callable[[], ComponentStatus],
        problem: Callable[[], str],
        pose: Callable[[], Pose | None],
        wall_clock: Callable[[], float] = time.time,
    ) -> None:
        super().__init__()
        self._robot_ref = robot_ref
        self._robot_status = robot_status
        self._problem = problem
        self._pose = pose
        self._operable_since = datetime.fromtimestamp(wall_clock(), UTC)

    async def robot_position(self) -> RobotPositionResult:
        """Return the robot, its position `x,y,th`, and when it was there.

        Raises:
            ComponentFailed: the robot has not told where it is.
        """
        pose = self._known_pose()
        position = f"{pose.x:.3f},{pose.y:.3f},{pose.th:.4f}"
        return RobotPositionResult(position_data=(position,), robot_ref=(self._robot_ref,), timestamp=pose.at)

    async def engine_status(self) -> EngineStatusResult:
        """Return whether the robot works, and since when the adapter has been operable."""
        return EngineStatusResult(status=self._robot_status(), operable_time=self._operable_since)

    @query
    async def pose(self) -> PoseResult:
        """Return where the robot is, with frame and time.

        Raises:
            ComponentFailed: the robot has not told where it is.
        """
        pose = self._known_pose()
        return PoseResult(x=pose.x, y=pose.y, th=pose.th, frame=pose.frame, timestamp=pose.at)

    @query
    async def health(self) -> str:
        """Return why the robot does not work, in a sentence; empty while it does."""
        return self._problem()

    def _known_pose(self) -> Pose:
        pose = self._pose()
        if pose is None:
            raise ComponentFailed(self._problem() or "the robot has not told where it is")
        return pose


class SystemInformation(PoseInformation, function="sensing"):
    """Reports the robot's pose, its status and its battery.

    The status is WARNING while the battery is low: all components work, and refuse goals other than the charger.

    Args:
        robot_ref: the id by which the robot is known, the only entry of `robot_ref`.
        robot_status: returns the status of the robot.
        problem: returns why it is not READY; empty: no more is known.
        pose: returns the robot's last pose; None while it has told none.
        battery: the robot's battery.
        wall_clock: epoch seconds.
    """

    def __init__(
        self,
        robot_ref: str,
        robot_status: Callable[[], ComponentStatus],
        problem: Callable[[], str],
        pose: Callable[[], Pose | None],
        battery: Battery,
        wall_clock: Callable[[], float] = time.time,
    ) -> None:
        super().__init__(robot_ref, robot_status, problem, pose, wall_clock)
        self._battery = battery

    async def engine_status(self) -> EngineStatusResult:
        """Return whether the robot works, and since when the adapter has been operable."""
        told = await super().engine_status()
        if self._battery.is_low and told.status is ComponentStatus.READY:
            return told.model_copy(update={"status": ComponentStatus.WARNING})
        return told

    @query
    async def battery(self) -> BatteryResult:
        """Return the state of the battery.

        Raises:
            ComponentFailed: the robot has not told it.
        """
        battery = self._battery
        if battery.percent is None:
            raise ComponentFailed(self._problem() or "the robot has not told the charge of its battery")
        return BatteryResult(percent=battery.percent, is_charging=battery.is_charging, is_low=battery.is_low)
