"""What a component's status follows from, and what is said of it."""

from math import nan

import pytest

from openrois.client.components import Move, Navigation, SystemInformation
from openrois.errors import ComponentFailed
from openrois.types.codes import ComponentStatus
from tests.support.ros_robot import MAPPING, message, odometry, staged

pytestmark = pytest.mark.extra(name="ros2")


async def test_a_robot_that_has_said_nothing_is_not_initialized_and_says_why() -> None:
    async with staged(is_linked=False) as stage:
        stage.is_alive = False
        stage.graph.problems["/odom"] = "no node publishes /odom"
        await stage.run(2.0)
        for name in ("navigation", "follower", "move", "teleoperation", "speech_synthesizer"):
            component = stage.component(name)
            assert component.status is ComponentStatus.UNINITIALIZED, name
            assert component.problem() == "the robot in ROS domain 0 cannot be reached: no node publishes /odom", name
        navigation = await stage.client.find(Navigation)
        async with navigation.bound():
            await navigation.set(target_positions=["1,1"])
            with pytest.raises(ComponentFailed, match=r"UNINITIALIZED.*no node publishes /odom"):
                await stage.client.run(navigation.start())
        information = await stage.client.find(SystemInformation)
        assert (await information.engine_status()).status is ComponentStatus.UNINITIALIZED
        health = await information.query("health")
        assert health == {"health": "the robot in ROS domain 0 cannot be reached: no node publishes /odom"}
        with pytest.raises(ComponentFailed, match="no node publishes /odom"):
            await information.robot_position()


async def test_a_topic_that_is_matched_and_silent_is_no_sign_of_life() -> None:
    async with staged(is_linked=False) as stage:
        stage.is_alive = False
        await stage.run(1.0)
        assert stage.component("move").problem().endswith("nothing has come on /odom yet")


async def test_a_speed_limit_that_no_node_hears_keeps_the_robot_from_goals() -> None:
    async with staged(problems={"/speed_limit": "no node subscribes to /speed_limit"}) as stage:
        for name in ("navigation", "follower"):
            assert stage.component(name).status is ComponentStatus.UNINITIALIZED, name
            assert stage.component(name).problem() == "no node subscribes to /speed_limit", name
        assert stage.component("move").status is ComponentStatus.READY


async def test_odometry_with_numbers_that_are_none_is_no_sign_of_life() -> None:
    async with staged() as stage:
        stage.is_alive = False
        for _ in range(40):
            stage.graph.say("/odom", odometry(nan, 0.0, 0.0))
            await stage.run(0.05)
        assert stage.component("move").status is ComponentStatus.ERROR
        assert stage.component("move").problem().endswith("the poses on /odom have numbers that are none")
        stage.is_alive = True
        await stage.run(1.0)
        assert stage.component("move").status is ComponentStatus.READY


async def test_an_end_without_a_match_keeps_its_components_alone() -> None:
    async with staged(is_linked=False) as stage:
        stage.graph.problems["/navigate_to_pose"] = "no node serves the action /navigate_to_pose"
        await stage.run(0.6)
        navigation, move = stage.component("navigation"), stage.component("move")
        assert move.status is ComponentStatus.READY
        assert navigation.status is ComponentStatus.UNINITIALIZED
        assert navigation.problem() == "no node serves the action /navigate_to_pose"
        del stage.graph.problems["/navigate_to_pose"]
        assert navigation.status is ComponentStatus.READY
        stage.graph.problems["/navigate_to_pose"] = "no node serves the action /navigate_to_pose"
        assert navigation.status is ComponentStatus.ERROR


async def test_a_robot_that_falls_silent_is_lost_with_what_moves_and_comes_back() -> None:
    async with staged() as stage:
        move = await stage.client.find(Move)
        async with move.bound():
            await move.set(line=[5000, 0])
            going = await stage.begun(stage.client.run(move.start()))
            stage.is_alive = False
            with pytest.raises(ComponentFailed, match=r"nothing has come on /odom for 1\.\d s"):
                await stage.until(going, 3.0)
        assert stage.component("move").status is ComponentStatus.ERROR
        assert stage.graph.velocities()[-1] == (0.0, 0.0)
        stage.is_alive = True
        await stage.run(1.0)
        assert stage.component("move").status is ComponentStatus.READY


async def test_the_pose_has_the_frame_and_the_time_of_the_robot() -> None:
    async with staged() as stage:
        stage.graph.say("/amcl_pose", odometry(1.5, -2.0, 0.5, frame="map", at=1_700_000_000.25))
        information = await stage.client.find(SystemInformation)
        pose = await information.query("pose")
        assert (pose["x"], pose["y"], pose["frame"]) == (1.5, -2.0, "map")
        assert pose["th"] == pytest.approx(0.5)
        assert pose["timestamp"].startswith("2023-11-14T22:13:20.25")
        position = await information.robot_position()
        assert position.position_data == ("1.500,-2.000,0.5000",)


async def test_without_a_localisation_the_pose_is_that_of_the_odometry() -> None:
    mapping = {name: value for name, value in MAPPING.items() if name != "pose"}
    async with staged(mapping) as stage:
        stage.graph.say("/odom", odometry(float("nan"), 0.0, 0.0))
        stage.graph.say("/odom", odometry(0.25, 0.0, 0.0, at=0.0))
        pose = await (await stage.client.find(SystemInformation)).query("pose")
        assert (pose["x"], pose["frame"]) == (0.25, "odom")
        # A robot that gives no time was there when its message came.
        assert pose["timestamp"].startswith("2027-01-15T08:00:00.")


async def test_the_battery_is_told_and_below_its_limit_all_goals_but_the_dock_are_refused() -> None:
    async with staged() as stage:
        information = await stage.client.find(SystemInformation)
        with pytest.raises(ComponentFailed, match="has not told the charge"):
            await information.query("battery")
        stage.tell_battery(0.193)
        assert await information.query("battery") == {"percent": 19, "is_charging": False, "is_low": True}
        assert (await information.engine_status()).status is ComponentStatus.WARNING
        navigation, move = await stage.client.find(Navigation), await stage.client.find(Move)
        async with navigation.bound(), move.bound():
            await navigation.set(target_positions=["table"])
            with pytest.raises(ComponentFailed, match="the battery is at 19 %; below 20 % only the charger is a goal"):
                await stage.client.run(navigation.start())
            await move.set(line=[100, 0])
            with pytest.raises(ComponentFailed, match="the battery is at 19 %"):
                await stage.client.run(move.start())
            await navigation.set(target_positions=["dock"])
            going = await stage.begun(stage.client.run(navigation.start()))
            stage.graph.goals[-1].end("succeeded")
            await stage.until(going, 1.0)


@pytest.mark.parametrize(
    ("told", "percent"),
    [
        ({"percentage": 0.5, "charge": 0.0, "capacity": 0.0}, 50),
        ({"percentage": 1.2, "charge": 0.0, "capacity": 0.0}, 100),
        ({"percentage": float("nan"), "charge": 2.0, "capacity": 8.0}, 25),
        ({"percentage": float("nan"), "charge": float("nan"), "capacity": float("nan")}, None),
    ],
)
async def test_drivers_tell_the_charge_in_several_ways(told: dict[str, float], percent: int | None) -> None:
    async with staged() as stage:
        stage.graph.say("/battery_state", message(**told, power_supply_status=1))
        if percent is None:
            with pytest.raises(ComponentFailed):
                await (await stage.client.find(SystemInformation)).query("battery")
        else:
            battery = await (await stage.client.find(SystemInformation)).query("battery")
            assert (battery["percent"], battery["is_charging"]) == (percent, True)


async def test_a_percentage_of_a_hundred_is_read_as_such() -> None:
    async with staged({**MAPPING, "battery": {"topic": "battery_state", "full": 100}}) as stage:
        stage.tell_battery(42.0)
        assert (await (await stage.client.find(SystemInformation)).query("battery"))["percent"] == 42


async def test_a_robot_without_odometry_is_there_when_one_of_its_ends_is_matched() -> None:
    mapping = {"speech": {"topic": "say"}}
    async with staged(mapping, is_linked=False, problems={"/say": "no node subscribes to /say"}) as stage:
        await stage.run(0.6)
        assert stage.component("speech_synthesizer").status is ComponentStatus.UNINITIALIZED
        assert stage.robot.link.problem == "the robot in ROS domain 0 cannot be reached: no node subscribes to /say"
        del stage.graph.problems["/say"]
        await stage.run(0.6)
        assert stage.component("speech_synthesizer").status is ComponentStatus.READY
