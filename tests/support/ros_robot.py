"""A robot that speaks ROS 2, of which tests say every message, on a clock that is moved by hand."""

import asyncio
from collections.abc import AsyncIterator, Awaitable, Callable, Mapping
from contextlib import asynccontextmanager
from math import atan2, cos, sin
from types import SimpleNamespace
from typing import Any, Self, TypeVar

from openrois_robots.ros2.adapter import Robot, ros_robot
from openrois_robots.ros2.graph.backend import GoalRejected, GoalResult, NoAnswer
from openrois_robots.ros2.graph.matching import Qos
from openrois_robots.ros2.mapping.reading import read_mapping

from openrois.client import Client
from openrois.errors import ComponentFailed
from openrois.testing import harness
from tests.support.streaming import VirtualClock, settle

__all__ = ["MAPPING", "FakeGoal", "FakeGraph", "Stage", "message", "odometry", "staged"]

MAPPING: Mapping[str, Any] = {
    "base": {"max_speed": 0.5, "max_turn": 1.0},
    "odometry": {"topic": "odom"},
    "pose": {"topic": "amcl_pose"},
    "battery": {"topic": "battery_state", "low": 20},
    "velocity": {"topic": "cmd_vel"},
    "navigation": {"action": "navigate_to_pose", "speed_limit": "speed_limit", "dock": "dock"},
    "places": {"dock": "0,0", "table": "1,2,1.5"},
    "follow": {"targets": {"visitor": "visitor_pose"}},
    "camera": {"front": {"topic": "camera/compressed", "width": 64, "height": 48}},
    "speech": {"topic": "say", "speaking": "speaking", "hush": "hush"},
}
"""A robot with everything."""

_E = TypeVar("_E", bound="FakeEnd")

TURN = 0.05
"""Seconds of the clock at a time."""


def message(**fields: Any) -> Any:
    """Return an object with these fields; mappings in it are objects too."""
    return SimpleNamespace(
        **{name: message(**value) if isinstance(value, dict) else value for name, value in fields.items()}
    )


def odometry(x: float, y: float, th: float, *, frame: str = "odom", at: float = 1_800_000_000.0) -> Any:
    """Return an `Odometry` or a `PoseWithCovarianceStamped`."""
    return message(
        header={"frame_id": frame, "stamp": {"sec": int(at), "nanosec": round(at % 1 * 1e9)}},
        pose={
            "pose": {
                "position": {"x": x, "y": y, "z": 0.0},
                "orientation": {"x": 0.0, "y": 0.0, "z": sin(th / 2), "w": cos(th / 2)},
            }
        },
    )


class FakeEnd:
    """An end of the graph, which tests match and unmatch."""

    def __init__(self, graph: "FakeGraph", name: str, type_name: str, qos: Qos | None = None) -> None:
        self.name = name
        self.type_name = type_name
        self.qos = qos
        self.is_closed = False
        self._graph = graph

    @property
    def is_matched(self) -> bool:
        return self.name not in self._graph.problems

    @property
    def problem(self) -> str:
        return self._graph.problems.get(self.name, "")

    def close(self) -> None:
        self.is_closed = True


class FakePublisher(FakeEnd):
    def publish(self, message: Mapping[str, Any]) -> None:
        if self.name in self._graph.broken:
            raise ComponentFailed("DDS refused a message")
        self._graph.published.append((self.name, message))


class FakeService(FakeEnd):
    async def call(self, request: Mapping[str, Any], timeout: float = 1.0) -> Any:
        self._graph.published.append((self.name, request))
        return await self._graph.answers[self.name]


class FakeGoal:
    """A goal that tests end."""

    def __init__(self, goal: Mapping[str, Any]) -> None:
        self.goal = goal
        self.canceled = 0
        self.confirms = True
        self.ending: asyncio.Future[GoalResult] = asyncio.get_running_loop().create_future()

    @property
    def place(self) -> tuple[float, float, float]:
        """Where it leads, and the direction there, in radians."""
        pose = self.goal["pose"]["pose"]
        turn = pose["orientation"]
        return pose["position"]["x"], pose["position"]["y"], 2 * atan2(turn["z"], turn["w"])

    def end(self, outcome: Any, **result: Any) -> None:
        if not self.ending.done():
            self.ending.set_result(GoalResult(outcome, message(**result)))

    async def result(self) -> GoalResult:
        return await asyncio.shield(self.ending)

    async def cancel(self, timeout: float = 1.0) -> None:
        self.canceled += 1
        if not self.confirms:
            raise NoAnswer("the action has not answered within 0.4 s")
        self.end("canceled")


class FakeAction(FakeEnd):
    async def send_goal(
        self, goal: Mapping[str, Any], on_feedback: Callable[[Any], None] = lambda _: None, timeout: float = 1.0
    ) -> FakeGoal:
        if self._graph.rejects:
            raise GoalRejected("the action has rejected the goal")
        made = FakeGoal(goal)
        self._graph.goals.append(made)
        return made


class FakeGraph:
    """A `RosBackend` in memory.

    Attributes:
        problems: by name, why an end is not matched.
        broken: names of topics on which nothing can be published.
        published: what was published, and asked of services, in order.
        goals: that were sent.
        answers: of services.
    """

    def __init__(self) -> None:
        self.problems: dict[str, str] = {}
        self.broken: set[str] = set()
        self.published: list[tuple[str, Mapping[str, Any]]] = []
        self.goals: list[FakeGoal] = []
        self.answers: dict[str, Awaitable[Any]] = {}
        self.rejects = False
        self.subscriptions: list[tuple[FakeEnd, Callable[[Any], None]]] = []
        self.ends: list[FakeEnd] = []

    async def __aenter__(self) -> Self:
        return self

    async def __aexit__(self, *_error: object) -> None: ...

    def publisher(self, topic: str, type_name: str, qos: Qos) -> FakePublisher:
        return self._added(FakePublisher(self, topic, type_name, qos))

    def subscribe(self, topic: str, type_name: str, qos: Qos, on_message: Callable[[Any], None]) -> FakeEnd:
        end = self._added(FakeEnd(self, topic, type_name, qos))
        self.subscriptions.append((end, on_message))
        return end

    def service(self, name: str, type_name: str) -> FakeService:
        return self._added(FakeService(self, name, type_name))

    def action(self, name: str, type_name: str) -> FakeAction:
        return self._added(FakeAction(self, name, type_name))

    def say(self, topic: str, what: Any) -> None:
        """Let the robot publish a message."""
        for end, on_message in self.subscriptions:
            if end.name == topic and not end.is_closed:
                on_message(what)

    def velocities(self) -> list[tuple[float, float]]:
        """Return the velocities that were published: m/s and rad/s."""
        twists = [what.get("twist", what) for name, what in self.published if name == "/cmd_vel"]
        return [(each["linear"]["x"], each["angular"]["z"]) for each in twists]

    def _added(self, end: _E) -> _E:
        self.ends.append(end)
        return end


class Stage:
    """The robot behind a gateway in memory, and an application.

    Attributes:
        graph: of the robot.
        robot: its adapter's side.
        client: the application.
        clock: of the adapter.
        obeys: whether the robot goes as it is told.
    """

    def __init__(self, graph: FakeGraph, robot: Robot, client: Client, clock: VirtualClock) -> None:
        self.graph = graph
        self.robot = robot
        self.client = client
        self.clock = clock
        self.obeys = True
        self.is_alive = True
        self.place = [0.0, 0.0, 0.0]

    def component(self, name: str) -> Any:
        """Return a component of the robot."""
        return next(each for each in self.robot.components if each.name == name)

    async def run(self, seconds: float) -> None:
        """Let time pass; the robot goes as it was told last, and says where it is."""
        for _ in range(round(seconds / TURN)):
            if self.is_alive:
                self.tell_place()
            await self.clock.advance(TURN)
            await settle()
            velocities = self.graph.velocities()
            if self.obeys and velocities:
                ahead, turn = velocities[-1]
                self.place[2] += turn * TURN
                self.place[0] += ahead * TURN * cos(self.place[2])
                self.place[1] += ahead * TURN * sin(self.place[2])

    def tell_place(self) -> None:
        """Say where the robot is."""
        self.graph.say("/odom", odometry(*self.place, at=self.clock.wall()))
        self.graph.say("/amcl_pose", odometry(*self.place, frame="map", at=self.clock.wall()))

    def tell_battery(self, share: float) -> None:
        """Say how full the battery is."""
        told = message(percentage=share, charge=float("nan"), capacity=float("nan"), power_supply_status=2)
        self.graph.say("/battery_state", told)

    async def until(self, work: Awaitable[Any], seconds: float = 60.0) -> Any:
        """Let time pass until something is done, and return what it returned."""
        done = asyncio.ensure_future(work)
        await settle()
        for _ in range(round(seconds / TURN)):
            if done.done():
                return done.result()
            await self.run(TURN)
        done.cancel()
        raise TimeoutError(f"not done within {seconds} s, with the robot at {self.place}")

    async def begun(self, work: Awaitable[Any], seconds: float = 0.2) -> "asyncio.Future[Any]":
        """Begin something, and let some time pass."""
        begun = asyncio.ensure_future(work)
        await settle()
        await self.run(seconds)
        return begun


@asynccontextmanager
async def staged(
    mapping: Mapping[str, Any] = MAPPING, *, is_linked: bool = True, problems: Mapping[str, str] | None = None
) -> AsyncIterator[Stage]:
    """Connect a robot for as long as the block runs."""
    clock, graph = VirtualClock(), FakeGraph()
    graph.problems |= problems or {}
    read = read_mapping(mapping)
    connecting = ros_robot("robot", read, graph, clock, "the robot in ROS domain 0")
    async with connecting as robot, harness(*robot.components) as client:
        stage = Stage(graph, robot, client, clock)
        if is_linked:
            await stage.run(0.6)
        yield stage
