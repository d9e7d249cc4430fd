"""The node of the simulated robot: its topics, its action, and its voice.

| topic, action | type | |
|---|---|---|
| `cmd_vel` | Twist | obeyed; 0.5 s without one, and it stands |
| `odom` | Odometry | 20 a second |
| `amcl_pose` | PoseWithCovarianceStamped | the same pose in the frame `map`; the last one is kept |
| `battery_state` | BatteryState | each second |
| `navigate_to_pose` | NavigateToPose | a new goal replaces the one before it; outside of its floor it is aborted |
| `speed_limit` | SpeedLimit | for goals |
| `camera/image_raw`, `camera/image_raw/compressed` | Image, CompressedImage | 15 a second, while something subscribes |
| `visitor_pose` | PoseStamped | a person who walks on a circle, 10 a second |
| `say`, `speaking`, `hush` | String, Bool, Empty | it speaks for half a second |
"""

import asyncio
from collections.abc import AsyncGenerator, Callable, Mapping
from dataclasses import dataclass
from math import cos, isfinite, sin
from typing import Any, Final

from openrois_streaming.clock import MediaClock

from openrois.aio.listeners import Listeners
from openrois.aio.tasks import TaskScope
from openrois_robots.ros2.cyclone.participant import Participant
from openrois_robots.ros2.cyclone.servers import Aborted, DdsActionServer
from openrois_robots.ros2.cyclone.topics import DdsPublisher, DdsSubscription
from openrois_robots.ros2.cyclone.types import TypeMaker
from openrois_robots.ros2.graph.matching import Qos
from openrois_robots.ros2.graph.names import resolve_name
from openrois_robots.ros2.interfaces.store import Interfaces
from openrois_robots.ros2.robot.poses import yaw
from openrois_robots.ros2.simulator.camera import SIZE, draw, jpeg
from openrois_robots.ros2.simulator.model import EDGE, Goal, Model

__all__ = ["SimulatedNode", "SimulatorSettings"]

_STEP: Final = 0.02
_ODOMETRY, _BATTERY, _CAMERA, _VISITOR = 0.05, 1.0, 1 / 15, 0.1
"""Seconds between two messages."""
_SPEAKING: Final = 0.5
_ROUND: Final = 40.0
"""Seconds in which the visitor walks round."""


@dataclass(frozen=True, slots=True)
class SimulatorSettings:
    """What is simulated.

    Attributes:
        domain: of DDS.
        namespace: of all names.
        distribution: of ROS.
        percent: charge of the battery at the beginning.
        reliability: of what it publishes: `reliable` or `best_effort`.
        rejects: whether it rejects all goals.
    """

    domain: int
    namespace: str = "/"
    distribution: str = "jazzy"
    percent: float = 80.0
    reliability: str = "reliable"
    rejects: bool = False


class SimulatedNode:
    """The node; `run` it.

    Args:
        settings: what is simulated.
        clock: drives it.

    Attributes:
        model: what moves.
        stopped: called when it is told to stop: by a velocity of zero, or because its goal is cancelled.
    """

    def __init__(self, settings: SimulatorSettings, clock: MediaClock) -> None:
        self.model = Model(percent=settings.percent)
        self.stopped: Listeners[()] = Listeners()
        self._settings = settings
        self._clock = clock
        self._pictures = 0
        self._executing = 0

    async def run(self, ready: Callable[[], None]) -> None:
        """Run the node until cancelled; `ready` is called once it is in the graph."""
        types = TypeMaker(Interfaces(self._settings.distribution))
        async with Participant(self._settings.domain) as participant, TaskScope() as tasks:
            self._listen(participant, types, tasks)
            publish = self._publishers(participant, types)
            action = resolve_name("navigate_to_pose", self._settings.namespace)
            DdsActionServer(participant, types, action, "nav2_msgs/action/NavigateToPose", self, tasks)
            tasks.start(self._move())
            tasks.start(self._every(_ODOMETRY, lambda: self._publish_place(publish)))
            tasks.start(self._every(_BATTERY, lambda: self._publish_battery(publish)))
            tasks.start(self._every(_CAMERA, lambda: self._publish_pictures(publish)))
            tasks.start(self._every(_VISITOR, lambda: self._publish_visitor(publish)))
            ready()
            await asyncio.Event().wait()

    def accepts(self, goal: Any) -> bool:
        """Return whether a goal is accepted; an `Execution`."""
        at = goal.pose.pose.position
        return not self._settings.rejects and isfinite(at.x) and isfinite(at.y)

    async def execute(self, goal: Any) -> AsyncGenerator[Mapping[str, Any], None]:
        """Drive to a goal.

        Raises:
            Aborted: it is outside of the floor, or another goal or velocity took its place.
        """
        at, number = goal.pose.pose.position, self._executing + 1
        self._executing = number
        if max(abs(at.x), abs(at.y)) > EDGE:
            raise Aborted({"error_code": 204, "error_msg": "the goal is outside of the map"})
        mine = Goal(at.x, at.y, yaw(goal.pose.pose.orientation))
        self.model.pursue(mine)
        try:
            while self.model.goal is mine:
                left = ((mine.x - self.model.x) ** 2 + (mine.y - self.model.y) ** 2) ** 0.5
                yield {"current_pose": self._stamped("map", self._pose()), "distance_remaining": left}
                await self._clock.sleep_until(self._clock.now() + 0.1)
        finally:
            if self.model.goal is mine:
                self.model.pursue(None)
                self.stopped.notify_all()
        if self._executing != number or not mine.is_there:
            raise Aborted({"error_code": 0, "error_msg": "another goal, or a velocity, took its place"})

    def _listen(self, participant: Participant, types: TypeMaker, tasks: TaskScope) -> None:
        def subscribe(name: str, type_name: str, take: Callable[[Any], None]) -> None:
            full = resolve_name(name, self._settings.namespace)
            DdsSubscription(participant, types, full, type_name, Qos(), take)

        speaking = DdsPublisher(
            participant, types, resolve_name("speaking", self._settings.namespace), "std_msgs/msg/Bool", Qos()
        )

        async def say() -> None:
            speaking.publish({"data": True})
            try:
                await self._clock.sleep_until(self._clock.now() + _SPEAKING)
            finally:
                speaking.publish({"data": False})

        speaks: list[asyncio.Task[None]] = []

        def speak(text: Any) -> None:
            hush(text)
            speaks.append(tasks.start(say()))

        def hush(_message: Any) -> None:
            while speaks:
                speaks.pop().cancel()

        def obey(twist: Any) -> None:
            self.model.obey(twist.linear.x, twist.angular.z, self._clock.now())
            if not (twist.linear.x or twist.angular.z):
                self.stopped.notify_all()

        def limit(message: Any) -> None:
            self.model.limit = message.speed_limit

        subscribe("cmd_vel", "geometry_msgs/msg/Twist", obey)
        subscribe("speed_limit", "nav2_msgs/msg/SpeedLimit", limit)
        subscribe("say", "std_msgs/msg/String", speak)
        subscribe("hush", "std_msgs/msg/Empty", hush)

    def _publishers(self, participant: Participant, types: TypeMaker) -> Mapping[str, DdsPublisher]:
        is_best_effort = self._settings.reliability == "best_effort"
        sensor = Qos("best_effort" if is_best_effort else "reliable", "volatile", 5)
        kinds = {
            "odom": ("nav_msgs/msg/Odometry", sensor),
            "amcl_pose": ("geometry_msgs/msg/PoseWithCovarianceStamped", Qos("reliable", "transient_local", 1)),
            "battery_state": ("sensor_msgs/msg/BatteryState", sensor),
            "camera/image_raw": ("sensor_msgs/msg/Image", sensor),
            "camera/image_raw/compressed": ("sensor_msgs/msg/CompressedImage", sensor),
            "visitor_pose": ("geometry_msgs/msg/PoseStamped", sensor),
        }
        return {
            name: DdsPublisher(participant, types, resolve_name(name, self._settings.namespace), kind, qos)
            for name, (kind, qos) in kinds.items()
        }

    async def _move(self) -> None:
        now = self._clock.now()
        while True:
            await self._clock.sleep_until(now + _STEP)
            while now + _STEP <= self._clock.now():
                now += _STEP
                self.model.step(_STEP, now)

    async def _every(self, seconds: float, publish: Callable[[], None]) -> None:
        due = self._clock.now()
        while True:
            publish()
            due = max(due + seconds, self._clock.now() - seconds)
            await self._clock.sleep_until(due)

    def _publish_place(self, publish: Mapping[str, DdsPublisher]) -> None:
        model = self.model
        odometry = self._stamped("odom", {"pose": self._pose()})
        twist = {"linear": {"x": model.speed}, "angular": {"z": model.turn}}
        publish["odom"].publish({**odometry, "child_frame_id": "base_link", "twist": {"twist": twist}})
        publish["amcl_pose"].publish(self._stamped("map", {"pose": self._pose()}))

    def _publish_battery(self, publish: Mapping[str, DdsPublisher]) -> None:
        publish["battery_state"].publish(
            {
                "header": self._header("base_link"),
                "percentage": self.model.percent / 100,
                "power_supply_status": 2,
                "present": True,
            }
        )

    def _publish_pictures(self, publish: Mapping[str, DdsPublisher]) -> None:
        raw, compressed = publish["camera/image_raw"], publish["camera/image_raw/compressed"]
        if not (raw.is_matched or compressed.is_matched):
            return
        self._pictures += 1
        picture = draw(self.model.x, self.model.y, self.model.th, self._pictures)
        header = self._header("camera")
        if compressed.is_matched:
            compressed.publish({"header": header, "format": "bgr8; jpeg compressed bgr8", "data": jpeg(picture)})
        if raw.is_matched:
            width, height = SIZE
            shape = {"width": width, "height": height, "step": 3 * width, "encoding": "bgr8"}
            raw.publish({"header": header, **shape, "data": picture.tobytes()})

    def _publish_visitor(self, publish: Mapping[str, DdsPublisher]) -> None:
        angle = self._clock.now() % _ROUND / _ROUND * 6.283185307
        pose = {"position": {"x": 3 * cos(angle), "y": 3 * sin(angle)}}
        publish["visitor_pose"].publish(self._stamped("map", pose))

    def _pose(self) -> Mapping[str, Any]:
        model = self.model
        return {
            "position": {"x": model.x, "y": model.y},
            "orientation": {"x": 0.0, "y": 0.0, "z": sin(model.th / 2), "w": cos(model.th / 2)},
        }

    def _stamped(self, frame: str, pose: Mapping[str, Any]) -> Mapping[str, Any]:
        return {"header": self._header(frame), "pose": pose}

    def _header(self, frame: str) -> Mapping[str, Any]:
        wall = self._clock.wall()
        return {"stamp": {"sec": int(wall), "nanosec": int(wall % 1 * 1e9)}, "frame_id": frame}
