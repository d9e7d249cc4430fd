"""A robot that is driven by hand: velocities within its limits, and a dead man's switch."""

import asyncio

import pytest
from openrois_body.teleoperation.steering import Velocity

from openrois.client.components import Navigation
from openrois.errors import Aborted, ComponentFailed
from tests.support.ros_robot import MAPPING, staged
from tests.support.teleoperation import Hand, W

pytestmark = pytest.mark.extra(name="ros2")


async def test_velocities_are_within_the_limits_and_end_when_nothing_renews_them() -> None:
    async with staged() as stage:
        component = stage.component("teleoperation")
        stage.obeys = False
        controls = component._controls
        controls.drive(Velocity(3.0, 2.0, -9.0))
        # The robot does not step sideways.
        assert stage.graph.velocities() == [(0.5, -1.0)]
        await stage.run(0.3)
        assert set(stage.graph.velocities()) == {(0.5, -1.0)}
        await stage.run(0.2)
        # Within half a second, and not once alone.
        assert stage.graph.velocities()[-1] == (0.0, 0.0)
        await stage.run(2.0)
        assert stage.graph.velocities().count((0.0, 0.0)) == 3


async def test_a_robot_that_steps_sideways_is_told_to() -> None:
    async with staged({**MAPPING, "velocity": {"topic": "cmd_vel", "sideways": True}}) as stage:
        stage.component("teleoperation")._controls.drive(Velocity(0.3, 0.4, 0.0))
        twist = stage.graph.published[-1][1]
        assert twist["linear"] == {"x": pytest.approx(0.3), "y": pytest.approx(0.4), "z": 0.0}
        stage.component("teleoperation")._controls.drive(Velocity(0.6, 0.8, 0.0))
        twist = stage.graph.published[-1][1]
        assert twist["linear"] == {"x": pytest.approx(0.3), "y": pytest.approx(0.4), "z": 0.0}


async def test_halting_says_zero_at_once() -> None:
    async with staged() as stage:
        controls = stage.component("teleoperation")._controls
        controls.drive(Velocity(0.3))
        controls.halt("released")
        assert stage.graph.velocities() == [(0.3, 0.0), (0.0, 0.0)]
        controls.turn_eyes(0, 0)
        controls.pass_on({})


async def test_driving_by_hand_takes_the_robot_from_its_goal() -> None:
    async with staged() as stage:
        navigation = await stage.client.find(Navigation)
        async with navigation.bound():
            await navigation.set(target_positions=["1,0"])
            going = await stage.begun(stage.client.run(navigation.start()))
            stage.component("teleoperation")._controls.drive(Velocity(0.3))
            await stage.run(0.2)
            assert stage.graph.goals[0].canceled == 1
            with pytest.raises(Aborted, match="an operator drives the body by hand"):
                await stage.until(going, 1.0)


async def test_an_operator_that_falls_silent_stops_the_robot() -> None:
    async with staged() as stage:
        stopped: list[str] = []
        pilot, hand = stage.component("teleoperation").pilot(stopped.append), Hand()
        watching = asyncio.ensure_future(pilot.watch())
        for _ in range(5):
            pilot.handle_input(hand.state(W), W)
            await stage.run(0.1)
        assert stage.graph.velocities()[-1] == (0.5, 0.0)
        assert stage.place[0] > 0.2
        await stage.run(0.4)
        assert stopped == ["no input came for 0.4 s"]
        assert stage.graph.velocities()[-1] == (0.0, 0.0)
        watching.cancel()


async def test_a_robot_that_takes_no_velocity_cannot_be_operated_and_says_why() -> None:
    async with staged() as stage:
        stage.graph.problems["/cmd_vel"] = "no node subscribes to /cmd_vel"
        component = stage.component("teleoperation")
        assert component.problem() == "no node subscribes to /cmd_vel"
        with pytest.raises(ComponentFailed, match="no node subscribes to /cmd_vel"):
            component._controls.drive(Velocity(0.3))


async def test_without_a_camera_there_is_no_way_for_an_operators_input() -> None:
    mapping = {name: value for name, value in MAPPING.items() if name != "camera"}
    async with staged(mapping) as stage:
        assert "teleoperation" not in {each.name for each in stage.robot.components}
