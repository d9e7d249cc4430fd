"""The parts of a robot that several components share, made of its mapping and its graph."""

from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from typing import Any, cast

from openrois_body.components.moving import Figure
from openrois_body.motion.legs import Legs
from openrois_body.motion.wayfinding import Ways
from openrois_body.motion.world import World
from openrois_streaming.clock import MediaClock

from openrois.adapter import ComponentFailed
from openrois_robots.adapter.link import RobotLink
from openrois_robots.ros2.components.bound import Ends
from openrois_robots.ros2.components.goals import Goals
from openrois_robots.ros2.graph.backend import Matched, RosBackend
from openrois_robots.ros2.graph.matching import Durability, Qos, Reliability
from openrois_robots.ros2.mapping.settings import (
    BATTERY,
    NAVIGATE,
    ODOMETRY,
    SPEED_LIMIT,
    TARGET,
    TWISTS,
    RobotMapping,
)
from openrois_robots.ros2.robot.poses import Heard
from openrois_robots.ros2.robot.state import BatteryState, OdometryState, PoseState, probe_any
from openrois_robots.ros2.robot.strokes import Limits
from openrois_robots.ros2.robot.wheels import Wheels

__all__ = ["Parts"]


def quality(reliability: str, durability: str = "volatile", depth: int = 1) -> Qos:
    """Return a quality of service, as a mapping file has it."""
    return Qos(cast("Reliability", reliability), cast("Durability", durability), depth)


@dataclass(slots=True)
class _Motion:
    """What moves the robot: its velocity, and its motions one at a time."""

    wheels: Wheels | None
    legs: Legs
    figure: Figure


class Parts:
    """Makes the parts; names that cannot be subscribed to raise `DefinitionError` here.

    Args:
        engine_id: leads every ref.
        mapping: of the robot.
        backend: its graph.
        clock: the media clock.
        robot: what is linked, for sentences.
    """

    def __init__(
        self, engine_id: str, mapping: RobotMapping, backend: RosBackend, clock: MediaClock, robot: str
    ) -> None:
        self.mapping = mapping
        self.backend = backend
        self.clock = clock
        self.battery = BatteryState(mapping.battery)
        self.world = World(engine_id)
        self.odometry = self._odometry()
        self.pose = self._pose()
        self._others: list[Matched] = []
        probe = self._probe_others if self.odometry is None else self.odometry.probe
        self.link = RobotLink(robot, probe, clock)
        self._listen_to_battery()
        base = self._motion()
        self.wheels, self.legs, self.figure = base.wheels, base.legs, base.figure
        self.goals, self._needed_by_goals = self._goals()

    def ends(self, *ends: Matched) -> Ends:
        """Return the ends of a component."""
        self._others += ends
        return Ends(self.link, ends)

    def velocity_ends(self) -> Ends:
        """Return what driving by velocity needs."""
        return self.ends(*(() if self.wheels is None else (self.wheels.publisher,)))

    def goal_ends(self) -> Ends:
        """Return what goals need: the action, and a node that hears the limit of their speed, where there is one."""
        return self.ends(*self._needed_by_goals)

    def pose_states(self, topics: Mapping[str, str], reliability: str) -> dict[str, PoseState]:
        """Return the last poses of topics of `PoseStamped`, by their names."""
        states = {name: PoseState(self.clock) for name in topics}
        for name, topic in topics.items():
            self.backend.subscribe(topic, TARGET, quality(reliability), states[name].note_message)
        return states

    def heard_pose(self) -> Heard | None:
        """Return the last pose of the robot: that of its map, where the mapping names one, else of its odometry."""
        state = self.pose or (None if self.odometry is None else self.odometry.pose)
        return None if state is None else state.heard

    def _stand(self) -> None:
        """Let the robot stand by its velocity, as far as it takes one."""
        if self.wheels is not None:
            with suppress(ComponentFailed):
                self.wheels.halt()

    async def _probe_others(self) -> None:
        await probe_any(tuple(self._others))

    def _odometry(self) -> OdometryState | None:
        settings = self.mapping.odometry
        if settings is None:
            return None
        state = OdometryState(settings, self.world, self.clock)
        state.subscription = self.backend.subscribe(
            settings.topic, ODOMETRY, quality(settings.reliability), state.note_message
        )
        return state

    def _pose(self) -> PoseState | None:
        settings = self.mapping.pose
        if settings is None:
            return None
        state = PoseState(self.clock)
        qos = quality(settings.reliability, settings.durability)
        self.backend.subscribe(settings.topic, settings.type, qos, state.note_message)
        return state

    def _listen_to_battery(self) -> None:
        settings = self.mapping.battery
        if settings is not None:
            self.backend.subscribe(settings.topic, BATTERY, quality(settings.reliability), self.battery.note_message)

    def _motion(self) -> _Motion:
        settings, limits = self.mapping.velocity, self.mapping.base
        wheels = None
        if settings is not None:
            publisher = self.backend.publisher(settings.topic, settings.type, quality(settings.reliability))
            frame = settings.frame if settings.type == TWISTS[1] else None
            wheels = Wheels(
                publisher, Limits(limits.max_speed, limits.max_turn), self.clock, frame, sideways=settings.sideways
            )
        send: Callable[[Any], None] = _ignore if wheels is None else wheels.send
        legs = Legs(send, lambda: True, lambda: self.world.place, self.clock, limits.max_speed)
        figure = Figure(legs, self.world, Ways(self.world), lambda: self.link.status)
        return _Motion(wheels, legs, figure)

    def _goals(self) -> tuple[Goals | None, tuple[Matched, ...]]:
        settings, backend = self.mapping.navigation, self.backend
        if settings is None:
            return None, ()
        action = backend.action(settings.action, NAVIGATE)
        limit = backend.publisher(settings.speed_limit, SPEED_LIMIT, Qos()) if settings.speed_limit else None
        speed = self.mapping.base.max_speed
        goals = Goals(action, settings, self.mapping.places, speed, limit, self.heard_pose, self._stand, self.clock)
        return goals, (action,) if limit is None else (action, limit)


def _ignore(_command: object) -> None:
    """Stand in for the wheels of a robot that has none: it goes where goals take it."""
