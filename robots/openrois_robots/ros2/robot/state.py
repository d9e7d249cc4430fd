"""What the robot has told of itself: whether it is alive, where it is, and how full its battery is."""

from dataclasses import dataclass
from math import isfinite
from typing import Any, Final

from openrois_body.messages import Place
from openrois_body.motion.world import World
from openrois_streaming.clock import MediaClock, wall_at

from openrois.adapter import ComponentFailed
from openrois_robots.adapter.battery import BatteryLimit, ReportedBattery
from openrois_robots.components.system_information import Pose
from openrois_robots.ros2.graph.backend import Matched, Subscription
from openrois_robots.ros2.mapping.settings import Battery, Odometry
from openrois_robots.ros2.robot.poses import Heard, read_heard

__all__ = ["BatteryState", "OdometryState", "PoseState", "probe_any"]

_CHARGING: Final = 1
"""`POWER_SUPPLY_STATUS_CHARGING` of `sensor_msgs/msg/BatteryState`."""


@dataclass(slots=True)
class PoseState:
    """The last pose of a topic.

    Attributes:
        clock: the media clock.
        heard: the last pose; None: there was none.
        came_at: when it came, in seconds of the media clock.
        is_flawed: whether the last message had numbers that are none.
    """

    clock: MediaClock
    heard: Heard | None = None
    came_at: float = 0.0
    is_flawed: bool = False

    def note_message(self, message: Any) -> None:
        """Note the pose of a message; one with numbers that are none is dropped."""
        heard = read_heard(message)
        self.is_flawed = heard is None
        if heard is not None:
            self.heard, self.came_at = heard, self.clock.now()

    def pose(self) -> Pose | None:
        """Return the pose for applications."""
        heard = self.heard
        if heard is None:
            return None
        return Pose(heard.x, heard.y, heard.th, heard.frame, heard.time(wall_at(self.clock, self.came_at)))


class OdometryState:
    """The odometry: the robot's place for its motions, and its sign of life.

    Args:
        settings: of its topic.
        world: gets the place.
        clock: the media clock.

    Attributes:
        pose: the last pose.
        subscription: to its topic, once there is one.
    """

    def __init__(self, settings: Odometry, world: World, clock: MediaClock) -> None:
        self.pose = PoseState(clock)
        self.subscription: Subscription | None = None
        self._settings = settings
        self._world = world
        self._clock = clock

    def note_message(self, message: Any) -> None:
        """Note a message."""
        before = self.pose.came_at
        self.pose.note_message(message)
        heard = self.pose.heard
        if heard is not None and self.pose.came_at >= before:
            self._world.handle_event(Place(heard.x, heard.y, heard.th))

    async def probe(self) -> None:
        """Return where the robot is alive.

        Raises:
            ComponentFailed: it is not; the sentence says what is missing.
        """
        if self.subscription is not None and (problem := self.subscription.problem):
            raise ComponentFailed(problem)
        topic, silence = self._settings.topic, self._settings.silence
        if self.pose.is_flawed:
            raise ComponentFailed(f"the poses on {topic} have numbers that are none")
        if self.pose.heard is None:
            raise ComponentFailed(f"nothing has come on {topic} yet")
        age = self._clock.now() - self.pose.came_at
        if age > silence:
            raise ComponentFailed(f"nothing has come on {topic} for {age:.1f} s")


class BatteryState(ReportedBattery):
    """The battery as `sensor_msgs/msg/BatteryState` tells it."""

    __slots__ = ("_full",)

    def __init__(self, settings: Battery | None) -> None:
        super().__init__(BatteryLimit(0.0 if settings is None else settings.low))
        self._full = 1.0 if settings is None else settings.full

    def note_message(self, message: Any) -> None:
        """Note a message; a driver that does not measure the percentage gives NaN, and charge and capacity instead."""
        share = message.percentage / self._full
        if not isfinite(share) and message.capacity > 0:
            share = message.charge / message.capacity
        if isfinite(share):
            self.percent = round(100 * min(1.0, max(0.0, share)))
        self.is_charging = message.power_supply_status == _CHARGING


async def probe_any(ends: tuple[Matched, ...]) -> None:
    """Return where one of the ends is matched: the sign of life of a robot without odometry.

    Raises:
        ComponentFailed: none is.
    """
    if not any(each.is_matched for each in ends):
        raise ComponentFailed(next(filter(None, (each.problem for each in ends)), "nothing of the robot is mapped"))
