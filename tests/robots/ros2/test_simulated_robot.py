"""A robot that speaks ROS 2 behind a real gateway: the simulated one, in a process of its own."""

import asyncio
import os
import signal
import time
from collections.abc import AsyncIterator
from contextlib import AsyncExitStack, asynccontextmanager
from dataclasses import dataclass
from math import dist
from typing import Any
from unittest.mock import patch

import pytest
from openrois_conformance.checks import ALL_CHECKS
from openrois_conformance.stage import Needs
from openrois_conformance.suite import Outcome, run_checks, visit
from openrois_robots.ros2.adapter import Robot, hosted_robot, ros_robot
from openrois_robots.ros2.cyclone.backend import CycloneBackend
from openrois_robots.ros2.graph.matching import BEST_EFFORT
from openrois_robots.ros2.interfaces.store import Interfaces
from openrois_robots.ros2.mapping.reading import read_mapping
from openrois_streaming.clock import SystemClock

from openrois.adapter.dialer import serve_parent
from openrois.client import Client
from openrois.client.components import Follow, Move, Navigation, SpeechSynthesis, SystemInformation
from openrois.errors import Aborted, ComponentFailed, RoISError
from openrois.types.codes import ComponentStatus
from tests.support.black_box import application
from tests.support.deployment import gateway
from tests.support.ros_graph import URI, Peer, free_domain, peer, until

SIMULATOR = "openrois_robots.ros2.simulator"
MAPPING: dict[str, Any] = {
    "odometry": {"topic": "odom"},
    "pose": {"topic": "amcl_pose"},
    "battery": {"topic": "battery_state"},
    "velocity": {"topic": "cmd_vel"},
    "navigation": {"action": "navigate_to_pose", "speed_limit": "speed_limit", "dock": "dock"},
    "places": {"dock": "0,0", "table": "0.5,0.3,1.5"},
    "follow": {"targets": {"visitor": "visitor_pose"}},
    "camera": {
        "video_streaming": {"topic": "camera/image_raw/compressed", "width": 320, "height": 240, "frame_rate": 15},
        "raw": {
            "topic": "camera/image_raw",
            "type": "sensor_msgs/msg/Image",
            "width": 320,
            "height": 240,
            "frame_rate": 15,
        },
    },
    "speech": {"topic": "say", "speaking": "speaking", "hush": "hush"},
}


@dataclass
class House:
    """The adapter of a robot behind a gateway.

    Attributes:
        robot: its adapter's side.
        url: of the gateway.
        domain: of DDS.
        seen: the last message of the robot's odometry, heard by another node.
    """

    robot: Robot
    url: str
    domain: int
    seen: list[Any]

    async def ready(self) -> None:
        """Wait until every component works."""
        components = self.robot.components
        await until(
            lambda: all(each.status is ComponentStatus.READY for each in components),
            f"not all is ready: {[(each.name, each.problem()) for each in components]}",
            30.0,
        )
        await until(lambda: bool(self.seen), "the odometry was not heard")

    @property
    def speed(self) -> float:
        """How fast the robot is, by its odometry: m/s and rad/s together."""
        twist = self.seen[-1].twist.twist
        return float(abs(twist.linear.x) + abs(twist.angular.z))

    async def drives(self) -> None:
        """Wait until the robot moves."""
        await until(lambda: self.speed > 0.1, "the robot did not move")

    async def stands(self, since: float, what: str, capsys: pytest.CaptureFixture[str]) -> None:
        """Wait until the robot stands, and print how long it took."""
        await until(lambda: self.speed == 0, f"the robot did not stand after {what}")
        with capsys.disabled():
            print(f"\n{what}: the robot stood after {1000 * (time.monotonic() - since):.0f} ms")


@asynccontextmanager
async def house(mapping: dict[str, Any] = MAPPING) -> AsyncIterator[House]:
    clock, domain, seen = SystemClock(), free_domain(), list[Any]()
    read = read_mapping(mapping)
    async with AsyncExitStack() as stack:
        stack.enter_context(patch.dict(os.environ, {"CYCLONEDDS_URI": URI}))
        running = await stack.enter_async_context(gateway())
        backend = await stack.enter_async_context(CycloneBackend(domain, Interfaces()))
        watching = await stack.enter_async_context(CycloneBackend(domain, Interfaces()))
        watching.subscribe("/odom", "nav_msgs/msg/Odometry", BEST_EFFORT, seen.append)
        connecting = ros_robot("robot", read, backend, clock, f"the robot in ROS domain {domain}")
        robot = await stack.enter_async_context(connecting)
        served = await stack.enter_async_context(hosted_robot("robot", robot, clock))
        url = running.url.replace("http", "ws", 1)
        there = asyncio.Event()
        serving = asyncio.create_task(serve_parent(served.host, f"{url}adapter", attached=lambda _: there.set()))
        try:
            async with asyncio.timeout(30):
                await there.wait()
            yield House(robot, url, domain, seen)
        finally:
            serving.cancel()
            await asyncio.wait({serving})


@asynccontextmanager
async def simulated(home: House, *arguments: str) -> AsyncIterator[Peer]:
    """Run the simulated robot in the domain of an adapter."""
    async with peer(SIMULATOR, "--domain", str(home.domain), *arguments) as robot:
        await robot.said("ready")
        yield robot


async def test_components_wait_for_the_robot_and_then_it_drives_turns_and_speaks() -> None:
    async with house() as home, Client(home.url) as client:
        navigation = await client.find(Navigation)
        async with navigation.bound():
            await navigation.set(target_positions=["table"])
            with pytest.raises(ComponentFailed, match=r"UNINITIALIZED.*no node publishes /odom"):
                await client.run(navigation.start())
        async with simulated(home):
            await home.ready()
            move, speech = await client.find(Move), await client.find(SpeechSynthesis)
            information = await client.find(SystemInformation)
            async with navigation.bound(), move.bound(), speech.bound():
                await client.run(navigation.start())
                pose = await information.query("pose")
                assert pose["frame"] == "map"
                assert dist((pose["x"], pose["y"]), (0.5, 0.3)) < 0.1
                assert pose["th"] == pytest.approx(1.5, abs=0.2)
                await move.set(line=[200, -45])
                await client.run(move.start())
                turned = await information.query("pose")
                assert turned["timestamp"] > pose["timestamp"]
                assert dist((turned["x"], turned["y"]), (pose["x"], pose["y"])) == pytest.approx(0.2, abs=0.1)
                await speech.set(speech_text="Hello.")
                await client.run(speech.start())
                await navigation.set(target_positions=["9,9"])
                with pytest.raises(ComponentFailed, match="could not get there: the goal is outside of the map"):
                    await client.run(navigation.start())
            assert (await information.query("battery"))["percent"] in (79, 80)


async def test_it_follows_a_person_until_it_is_stopped() -> None:
    async with house() as home, Client(home.url) as client, simulated(home):
        await home.ready()
        follow = await client.find(Follow)
        async with follow.bound():
            await follow.set(target_object_ref="visitor", distance=1000)
            following = asyncio.ensure_future(client.run(follow.start()))
            await home.drives()
            await client.run(follow.stop())
            with pytest.raises(Aborted):
                await following
            await until(lambda: home.speed == 0, "the robot did not stand")


@pytest.mark.parametrize("what", ["navigation", pytest.param("move", marks=pytest.mark.long)])
@pytest.mark.parametrize("how", ["stop", pytest.param("emergency stop", marks=pytest.mark.long), "application gone"])
async def test_every_way_to_stop_stops_it(what: str, how: str, capsys: pytest.CaptureFixture[str]) -> None:
    async with house() as home, simulated(home), Client(home.url) as other:
        await home.ready()
        async with Client(home.url) as client:
            component: Any = await client.find(Navigation if what == "navigation" else Move)
            await component.bind()
            target = {"target_positions": ["4.5,0"]} if what == "navigation" else {"line": [4500, 0]}
            await component.set(**target)
            going = asyncio.ensure_future(client.run(component.start()))
            await home.drives()
            since = time.monotonic()
            if how == "stop":
                await client.run(component.stop())
            elif how == "emergency stop":
                await other.control.stop_all()
            if how != "application gone":
                with pytest.raises(RoISError):
                    await going
        since = time.monotonic() if how == "application gone" else since
        await home.stands(since, f"{what}, {how}", capsys)
        await asyncio.gather(going, return_exceptions=True)


@pytest.mark.parametrize("how", [signal.SIGKILL, pytest.param(signal.SIGSTOP, marks=pytest.mark.long)])
async def test_a_robot_that_is_gone_or_hangs_ends_its_commands_and_comes_back(how: signal.Signals) -> None:
    async with house() as home, Client(home.url) as client:
        async with simulated(home) as robot:
            await home.ready()
            navigation = await client.find(Navigation)
            async with navigation.bound():
                await navigation.set(target_positions=["4.5,0"])
                going = asyncio.ensure_future(client.run(navigation.start()))
                await home.drives()
                os.kill(robot.process.pid, how)
                async with asyncio.timeout(20):
                    with pytest.raises(
                        ComponentFailed, match=r"the robot in ROS domain|the goal is lost|the node .* is gone"
                    ):
                        await going
                await until(lambda: home.robot.link.status is ComponentStatus.ERROR, "the loss was not noticed")
            if how is signal.SIGSTOP:
                os.kill(robot.process.pid, signal.SIGCONT)
                await home.ready()
                # It does not go on with what was given up meanwhile.
                await until(lambda: home.speed == 0, "the robot drives on")
        if how is signal.SIGKILL:
            async with simulated(home):
                await home.ready()


async def test_quality_of_service_that_does_not_match_is_the_status_with_what_to_change() -> None:
    mapping = {**MAPPING, "odometry": {"topic": "odom", "reliability": "reliable"}}
    async with house(mapping) as home, simulated(home, "--best-effort"), Client(home.url) as client:
        said = (
            '/odom is published best_effort, and the mapping file has reliable: set reliability = "best_effort" for it'
        )
        await until(lambda: said in home.robot.link.problem, "it was not said")
        navigation = await client.find(Navigation)
        assert await navigation.query("component_status") == {"status": "UNINITIALIZED"}
        async with navigation.bound():
            await navigation.set(target_positions=["table"])
            with pytest.raises(ComponentFailed, match="set reliability = "):
                await client.run(navigation.start())
        information = await client.find(SystemInformation)
        assert said in (await information.query("health"))["health"]


async def test_a_robot_that_rejects_goals_is_said_to() -> None:
    async with house() as home, simulated(home, "--reject"), Client(home.url) as client:
        await home.ready()
        navigation = await client.find(Navigation)
        async with navigation.bound():
            await navigation.set(target_positions=["table"])
            with pytest.raises(ComponentFailed, match="the action /navigate_to_pose has rejected the goal"):
                await client.run(navigation.start())


async def test_goals_of_another_distribution_are_said_to_be_of_another_definition() -> None:
    async with house() as home, simulated(home, "--distribution", "humble"):
        navigation: Any = next(each for each in home.robot.components if each.name == "navigation")
        await until(lambda: "another definition" in navigation.problem(), "it was not said")
        assert navigation.status is ComponentStatus.UNINITIALIZED


@pytest.mark.media
@pytest.mark.parametrize("camera", ["video_streaming", pytest.param("raw", marks=pytest.mark.long)])
async def test_a_viewer_sees_what_its_camera_sees(camera: str) -> None:
    async with house() as home, simulated(home), application(home.url) as app:
        await app.hello()
        await home.ready()
        stream_id = await app.play(f"robot/{camera}")
        await app.frames(stream_id, 5)
        seen = app.media(stream_id).luma
        assert seen is not None
        assert seen.shape == (240, 320)
        assert seen.std() > 10


async def test_every_component_conforms() -> None:
    checks = [check for check in ALL_CHECKS if Needs.COMPONENT in check.needs]
    # On a busy machine the robot may be silent for longer than a second, and is not lost for that here.
    patient = {**MAPPING, "odometry": {"topic": "odom", "silence": 20}}
    async with house(patient) as home, simulated(home):
        await home.ready()
        async with Client(home.url) as client:
            (body,) = await client.bodies()
        refs = [each.component_ref for each in body.components]
        assert len(refs) == 8
        for ref in refs:
            async with visit(home.url, 20.0, adapter=False, component=ref) as place:
                verdicts = await run_checks(place, checks)
            wrong = {
                each.check.id: f"{each.expected} / {each.came}"
                for each in verdicts
                if each.outcome is not Outcome.PASSED
            }
            assert wrong == {}, ref
