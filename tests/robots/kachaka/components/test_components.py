"""The Kachaka's components, behind a gateway in memory."""

import asyncio
import base64
from datetime import datetime
from math import pi
from typing import Any

import cv2
import numpy as np
import pytest
from openrois_robots.adapter.battery import BatteryLimit
from openrois_robots.kachaka.limits import DrivingLimits, SpeechSettings
from openrois_robots.kachaka.simulator.house import Pose
from openrois_robots.kachaka.simulator.robot import RobotSettings
from openrois_robots.kachaka.simulator.servicer import SimulatorServicer

from openrois.client.components import (
    Move,
    Navigation,
    PersonDetection,
    PersonLocalization,
    Reaction,
    SpeechSynthesis,
    SystemInformation,
)
from openrois.errors import Aborted, BadParameter, ComponentFailed, OutOfResources, TimedOut
from tests.support.kachaka import Linked, staged
from tests.support.robots import ended, until

pytestmark = pytest.mark.extra(name="kachaka")


async def navigate(stage: Linked, *targets: str, **more: object) -> None:
    navigation = await stage.client.find(Navigation)
    async with navigation.bound():
        await navigation.set(target_positions=list(targets), **more)  # type: ignore[arg-type]
        await stage.client.run(navigation.start())


async def move(stage: Linked, **parameters: object) -> None:
    component = await stage.client.find(Move)
    async with component.bound():
        await component.set(**parameters)  # type: ignore[arg-type]
        await stage.client.run(component.start())


async def speak(stage: Linked, text: str, **more: object) -> None:
    speech = await stage.client.find(SpeechSynthesis)
    async with speech.bound():
        await speech.set(speech_text=text, **more)  # type: ignore[arg-type]
        await stage.client.run(speech.start())


def at(stage: Linked) -> Any:
    """Return where the robot is, about."""
    pose = stage.simulation.body.pose
    return pytest.approx((pose.x, pose.y, pose.th), abs=0.01)


class TestNavigation:
    async def test_it_drives_to_locations_by_name_to_poses_and_home(self) -> None:
        async with staged() as stage:
            navigation = await stage.client.find(Navigation)
            async with navigation.reached_target() as reached:
                await navigate(stage, "kitchen", "1,-1,1.57")
                assert at(stage) == (1.0, -1.0, 1.57)
                events = aiter(reached)
                first, last = await anext(events), await anext(events)
            assert [(each.target, each.is_final_target) for each in (first, last)] == [
                ("kitchen", False),
                ("1,-1,1.57", True),
            ]
            await navigate(stage, "L02")
            assert at(stage) == (4.5, -1.8, -1.57)
            await navigate(stage, "home")
            assert at(stage) == (0.0, 0.0, 0.0)
            assert stage.simulation.premises.is_docked

    async def test_without_a_direction_it_ends_along_its_way(self) -> None:
        async with staged(at=Pose(1.0, 0.0)) as stage:
            await until(lambda: stage.robot.state.pose is not None and stage.robot.state.pose.x == 1.0)
            await navigate(stage, "1.0,1.5")
            assert at(stage) == (1.0, 1.5, pi / 2)

    @pytest.mark.parametrize(
        ("target", "why"),
        [
            ("garden", "'garden' is no location of the robot: there is 'home', 'charger', 'kitchen', "),
            ("1,2,3,4", "'1,2,3,4' is no location of the robot"),
            ("1,inf", "'1,inf': expected metres from -1000 to 1000, and radians"),
            ("3.6,0", "the robot did not go to '3.6,0': No way: There is no way to the destination (error 10003)"),
        ],
    )
    async def test_it_refuses_with_a_reason(self, target: str, why: str) -> None:
        async with staged() as stage:
            with pytest.raises((BadParameter, ComponentFailed)) as raised:
                await navigate(stage, target)
            assert why in str(raised.value)

    async def test_its_time_limit_ends_it_and_the_robot_stands(self) -> None:
        async with staged(1.0) as stage:
            with pytest.raises(TimedOut, match="navigation took longer than 300 ms"):
                await navigate(stage, "kitchen", time_limit=300)
            assert not stage.simulation.jobs

    async def test_it_stands_while_it_is_suspended_and_goes_on(self) -> None:
        async with staged(2.0) as stage:
            navigation = await stage.client.find(Navigation)
            going = asyncio.ensure_future(navigate(stage, "1.0,0"))
            await until(lambda: stage.simulation.body.pose.x > 0.1)
            await navigation.command("suspend")
            assert not stage.simulation.jobs
            where = stage.simulation.body.pose
            await asyncio.sleep(0)
            assert not going.done()
            await navigation.command("resume")
            await going
            assert where.x < 0.9
            assert at(stage) == (1.0, 0.0, 0.0)


class TestMove:
    async def test_it_goes_and_turns(self) -> None:
        async with staged() as stage:
            await move(stage, line=[1000, 90])
            assert at(stage) == (1.0, 0.0, pi / 2)
            await move(stage, line=[-300, -450])
            assert at(stage) == (1.0, -0.3, 0.0)

    async def test_a_curve_is_refused_truthfully(self) -> None:
        async with staged() as stage:
            with pytest.raises(ComponentFailed, match="a Kachaka drives no curves: set line, or operate it by hand"):
                await move(stage, curve=[500, 90])

    async def test_it_goes_no_faster_than_its_limit(self) -> None:
        async with staged(driving=DrivingLimits(speed=0.1)) as stage:
            with pytest.raises(ComponentFailed, match=r"1000 mm in 5000 ms are 0\.2 m/s; the speed must be between"):
                await move(stage, line=[1000, 0], time=5000)
            going = asyncio.ensure_future(move(stage, line=[1000, 0]))
            await until(lambda: stage.simulation.jobs)
            assert stage.simulation.jobs[0].command.move_forward_command.speed == pytest.approx(0.1)
            await going

    async def test_what_is_in_the_way_ends_it_with_the_robots_words(self) -> None:
        async with staged() as stage:
            with pytest.raises(ComponentFailed, match="the robot did not go 5000 mm: Blocked: Something is in the way"):
                await move(stage, line=[5000, 0])

    @pytest.mark.parametrize("line", [[1], [1, 2, 3], [1_000_000, 0], [0, 5000]])
    async def test_wrong_lines_are_refused(self, line: list[int]) -> None:
        async with staged() as stage:
            with pytest.raises(ComponentFailed, match="line: expected"):
                await move(stage, line=line)


class TestStop:
    async def test_the_red_button_stops_the_robot(self) -> None:
        async with staged(1.0) as stage:
            going = asyncio.ensure_future(navigate(stage, "kitchen"))
            await until(lambda: stage.simulation.jobs)
            await stage.client.control.stop_all()
            assert not stage.simulation.jobs
            assert isinstance(await ended(going), Aborted)

    async def test_an_emergency_stop_ends_everything_and_says_why_nothing_works(self) -> None:
        async with staged(1.0) as stage:
            going = asyncio.ensure_future(navigate(stage, "kitchen"))
            await until(lambda: stage.simulation.jobs)
            await stage.client.component("robot/emergency_stop").command("press")
            assert isinstance(await ended(going), ComponentFailed)
            await until(lambda: stage.robot.state.problem())
            with pytest.raises(ComponentFailed, match="the robot is not ready: Emergency stop: The emergency stop is"):
                await navigate(stage, "kitchen")
            stage.simulation.release()
            await until(lambda: not stage.robot.state.problem())


class TestBattery:
    async def test_a_low_battery_refuses_all_but_the_charger(self) -> None:
        low = RobotSettings(battery=12.3)
        async with staged(simulation=low, at=Pose(1, 0), battery=BatteryLimit(15)) as stage:
            information = await stage.client.find(SystemInformation)
            assert (await information.query("battery"))["is_low"]
            assert (await information.engine_status()).status.value == "WARNING"
            reason = "the battery is at 12 %; below 15 % only the charger is a goal"
            for refused in (navigate(stage, "kitchen"), navigate(stage, "home", "1,1"), move(stage, line=[100, 0])):
                with pytest.raises(ComponentFailed, match=reason):
                    await refused
            await navigate(stage, "home")
            assert at(stage) == (0.0, 0.0, 0.0)

    async def test_the_dock_is_reached_and_tells_of_charging(self) -> None:
        async with staged(at=Pose(1, 0)) as stage:
            dock = stage.client.component("robot/dock")
            await until(lambda: stage.robot.state.battery.percent is not None)
            async with dock.bound(), dock.event("battery_changed") as changed:
                await dock.command("start")
                async for event in changed:
                    if event["is_charging"]:
                        break
            assert stage.simulation.premises.is_docked


class TestSpeech:
    async def test_it_ends_when_the_robot_has_spoken(self) -> None:
        async with staged() as stage:
            await speak(stage, "Hello", volume=72)
            assert stage.simulation.volume == 7
            assert stage.simulation.last is not None
            assert stage.simulation.last.command.speak_command.text == "Hello"

    async def test_without_a_volume_the_robots_own_stays(self) -> None:
        async with staged() as stage:
            stage.simulation.volume = 3
            await speak(stage, "Hello")
            assert stage.simulation.volume == 3

    async def test_a_robot_that_can_speaks_while_it_drives(self) -> None:
        both = RobotSettings(speaks_while_driving=True)
        async with staged(4.0, simulation=both) as stage:
            going = asyncio.ensure_future(navigate(stage, "kitchen"))
            await until(lambda: stage.simulation.jobs)
            await speak(stage, "On my way")
            assert stage.simulation.jobs, "it still drives"
            await going

    async def test_a_robot_that_cannot_speaks_afterwards_and_goes_on_driving(self) -> None:
        async with staged(8.0) as stage:
            going = asyncio.ensure_future(move(stage, line=[600, 0]))
            await until(lambda: stage.simulation.jobs)
            speaking = asyncio.ensure_future(speak(stage, "On my way"))
            await asyncio.gather(going, speaking)
            assert [each.command.WhichOneof("command") for each in stage.simulation.history] == [
                "move_forward_command",
                "speak_command",
            ]

    async def test_it_is_refused_while_driving_where_that_is_set(self) -> None:
        async with staged(1.0, speech=SpeechSettings("refuse")) as stage:
            going = asyncio.ensure_future(navigate(stage, "kitchen"))
            await until(lambda: stage.simulation.jobs)
            with pytest.raises(OutOfResources, match="set not to be asked to speak meanwhile"):
                await speak(stage, "On my way")
            assert stage.simulation.jobs
            going.cancel()
            await ended(going)


class TestReaction:
    async def test_it_plays_the_robots_sounds_and_flashes_its_lights(self) -> None:
        async with staged() as stage:
            reaction = await stage.client.find(Reaction)
            refs = await reaction.available_reactions()
            assert [ref.rpartition("::")[2] for ref in refs] == [
                "kachaka/sound/chime",
                "kachaka/sound/thanks",
                "kachaka/front_light",
                "kachaka/back_light",
            ]
            async with reaction.bound():
                await reaction.set(reaction_ref=refs[0])
                await stage.client.run(reaction.start())
                assert list(stage.simulation.sounds) == ["chime"]
                await reaction.set(reaction_ref=refs[2])
                flashing = asyncio.ensure_future(stage.client.run(reaction.start()))
                await until(lambda: stage.simulation.lights["front"] == 255)
                await flashing
                assert stage.simulation.lights["front"] == 0
                with pytest.raises(ComponentFailed, match="there is no reaction 'urn:x-rois:def:reaction:OMG::1'"):
                    await reaction.set(reaction_ref="urn:x-rois:def:reaction:OMG::1")

    async def test_a_robot_without_lights_offers_none(self) -> None:
        async with staged(simulation=RobotSettings(torches=False)) as stage:
            refs = await (await stage.client.find(Reaction)).available_reactions()
            assert [ref for ref in refs if "light" in ref] == []


class TestShelves:
    async def test_it_carries_a_shelf_and_brings_it_home(self) -> None:
        async with staged() as stage:
            shelves = stage.client.component("robot/shelves")
            assert await shelves.query("shelves") == {
                "name": ["tea shelf", "book shelf"],
                "position_data": ["1.200,1.800,1.5700", "2.600,1.800,1.5700"],
                "home": ["tea corner", "library"],
            }
            async with shelves.bound():
                carrying = asyncio.ensure_future(shelves.command("move_shelf", shelf="tea shelf", location="sofa"))
                await until(lambda: stage.simulation.premises.carried)
                assert await shelves.query("carried_shelf") == {"carried_shelf": "tea shelf"}
                await carrying
                assert stage.simulation.premises.shelf_poses["S01"].x == pytest.approx(4.5)
                await shelves.command("return_shelf", shelf="tea shelf")
                assert stage.simulation.premises.shelf_poses["S01"].x == pytest.approx(1.2)
                with pytest.raises(ComponentFailed, match="'wine' is no shelf of the robot: there is 'tea shelf'"):
                    await shelves.command("move_shelf", shelf="wine", location="sofa")
                with pytest.raises(ComponentFailed, match="'moon' is no location of the robot: there is 'charger'"):
                    await shelves.command("move_shelf", shelf="tea shelf", location="moon")
                with pytest.raises(ComponentFailed, match="the robot did not set its shelf down: No shelf"):
                    await shelves.command("undock_shelf")

    async def test_stop_ends_what_carries(self) -> None:
        async with staged(1.0) as stage:
            shelves = stage.client.component("robot/shelves")
            async with shelves.bound():
                carrying = asyncio.ensure_future(shelves.command("move_shelf", shelf="tea shelf", location="sofa"))
                await until(lambda: stage.simulation.jobs)
                await shelves.command("stop")
                assert not stage.simulation.jobs
                assert str(await ended(carrying)).endswith("ended ABORT: shelves was stopped")


class TestMap:
    async def test_a_small_map_comes_as_it_is(self) -> None:
        async with staged() as stage:
            told = await stage.client.component("robot/map").query("map")
            picture = cv2.imdecode(np.frombuffer(base64.b64decode(told["png"]), np.uint8), cv2.IMREAD_GRAYSCALE)
            assert picture is not None
            assert (picture == stage.simulation.house.grid()).all()
            assert (told["name"], told["frame"], told["origin"]) == ("home", "map", "-0.500,-2.500,0.0000")
            assert (told["width"], told["height"], told["resolution"]) == (140, 100, 0.05)

    async def test_a_map_of_five_megabytes_is_made_smaller(self) -> None:
        noise = np.random.default_rng(1).integers(0, 256, (2300, 2300), np.uint8)
        _, data = cv2.imencode(".png", noise)
        assert len(data) > 5_000_000
        async with staged() as stage:
            stage.servicer.map_data = data.tobytes()
            told = await stage.client.component("robot/map").query("map")
            assert len(told["png"]) < 700_000, "a message of RoIS holds it"
            assert told["resolution"] * told["width"] == pytest.approx(2300 * 0.05, rel=0.02)

    async def test_a_map_that_is_no_picture_is_an_error(self) -> None:
        async with staged() as stage:
            stage.servicer.map_data = b"none"
            with pytest.raises(ComponentFailed, match="the robot's map is no picture that can be read"):
                await stage.client.component("robot/map").query("map")

    async def test_the_locations_have_poses(self) -> None:
        async with staged() as stage:
            told = await stage.client.component("robot/map").query("locations")
            assert told["charger"] == "charger"
            assert dict(zip(told["name"], told["position_data"], strict=True))["kitchen"] == "5.500,1.500,0.0000"

    async def test_the_surroundings_have_floor_and_locations(self) -> None:
        async with staged() as stage:
            surroundings = stage.client.component("robot/surroundings")
            await until(lambda: stage.robot.state.world.floor)
            floor = await surroundings.query("floor")
            assert len(floor["outline"]) >= 4
            assert len(floor["obstacles"]) == 1, "the table; the sideboard is part of the wall"
            things = await surroundings.query("things")
            assert {"kitchen", "tea shelf"} <= set(things["name"])


class TestInformation:
    async def test_a_pose_has_its_frame_and_time(self) -> None:
        async with staged(at=Pose(1.5, -0.5, 1.0)) as stage:
            await until(lambda: stage.robot.state.pose is not None and stage.robot.state.pose.x == 1.5)
            information = await stage.client.find(SystemInformation)
            pose = await information.query("pose")
            assert (pose["x"], pose["y"], pose["th"], pose["frame"]) == (1.5, -0.5, 1.0, "map")
            position = await information.robot_position()
            assert position.position_data == ("1.500,-0.500,1.0000",)
            assert position.timestamp >= datetime.fromisoformat(pose["timestamp"])

    async def test_errors_are_told_in_the_robots_words(self) -> None:
        async with staged() as stage:
            stage.simulation.stop_in_emergency()
            await until(lambda: stage.robot.state.problem())
            information = await stage.client.find(SystemInformation)
            assert (await information.query("health"))["health"] == (
                "the robot is not ready: Emergency stop: The emergency stop is active (error 20001)"
            )
            assert (await information.engine_status()).status.value == "ERROR"


class TestPersons:
    async def test_the_robots_detections_are_persons_with_places(self) -> None:
        async with staged(at=Pose(0.0, 0.2)) as stage:
            detection = await stage.client.find(PersonDetection)
            localization = await stage.client.find(PersonLocalization)
            assert "detection" not in stage.servicer.calls, "nothing is asked for while it is not wanted"
            async with detection.person_detected() as detected, localization.person_localized() as localized:
                async for event in detected:
                    if event.number:
                        break
                assert event.number == 1
                place = await anext(aiter(localized))
            x, y, _ = map(float, place.position_data[0].split(","))
            assert (x, y) == (pytest.approx(2.4, abs=0.1), pytest.approx(0.2, abs=0.1)), "on the map"
            assert place.person_ref[0].endswith("robot/detected/1")

    async def test_a_person_whose_distance_is_not_measured_is_counted_and_has_no_place(self) -> None:
        class OnItsCharger(SimulatorServicer):
            async def GetObjectDetection(self, request: Any, context: Any) -> Any:  # noqa: N802
                response = await SimulatorServicer.GetObjectDetection(self, request, context)
                for each in response.objects:
                    each.distance_median = 0.0
                return response

        async with staged(at=Pose(0.0, 0.2), servicer=OnItsCharger) as stage:
            detection = await stage.client.find(PersonDetection)
            localization = await stage.client.find(PersonLocalization)
            async with localization.person_localized() as localized, detection.person_detected() as detected:
                assert (await anext(each async for each in detected if each.number)).number == 1
                asked = stage.servicer.calls["detection"]
                await until(lambda: stage.servicer.calls["detection"] > asked + 3)
                waiting = asyncio.ensure_future(anext(aiter(localized)))
                await asyncio.sleep(0)
                assert not waiting.done()
                waiting.cancel()
                await ended(waiting)
