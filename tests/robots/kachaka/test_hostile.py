"""A robot that tells what no robot should: numbers that are none, names twice, pictures of any size."""

import asyncio
from collections.abc import Mapping
from typing import Any

import pytest
from kachaka_api.generated import kachaka_api_pb2 as pb2
from openrois_body.sensing.changes import Place
from openrois_robots.kachaka.adapter import VIDEO
from openrois_robots.kachaka.simulator.house import Pose
from openrois_robots.kachaka.simulator.servicer import SimulatorServicer

from openrois.client.components import Navigation, PersonDetection, PersonLocalization, SystemInformation
from openrois.errors import ComponentFailed
from tests.support.image_files import JPEG, resized
from tests.support.kachaka import staged
from tests.support.robots import ended, until

NAN, INF = float("nan"), float("inf")


def telling(**answers: Any) -> type[SimulatorServicer]:
    """Return a service with these answers in place of its own."""

    def method(answer: Any) -> Any:
        async def tell(_self: Any, _request: Any, _context: Any) -> Any:
            return answer

        return tell

    return type("Hostile", (SimulatorServicer,), {name: method(answer) for name, answer in answers.items()})


@pytest.mark.parametrize("pose", [{"x": NAN}, {"y": INF}, {"theta": NAN}, {"x": 1e30}])
async def test_a_pose_with_numbers_that_are_none_is_no_pose(pose: Mapping[str, float]) -> None:
    hostile = telling(GetRobotPose=pb2.GetRobotPoseResponse(pose=pb2.Pose(**pose)))
    async with staged(servicer=hostile) as stage:
        information = await stage.client.find(SystemInformation)
        for asking in (information.robot_position(), information.query("pose")):
            with pytest.raises(ComponentFailed, match="the robot has not told where it is"):
                await asking
        assert stage.robot.state.world.place is None


@pytest.mark.parametrize(("charge", "percent"), [(NAN, None), (INF, None), (1e30, 100), (-3.0, 0), (79.6, 80)])
async def test_a_charge_is_within_its_bounds_or_not_known(charge: float, percent: int | None) -> None:
    battery = pb2.GetBatteryInfoResponse(remaining_percentage=charge)
    async with staged(servicer=telling(GetBatteryInfo=battery)) as stage:
        assert stage.robot.state.battery.percent == percent
        await until(lambda: stage.servicer.calls["error"] > 1)
        assert stage.robot.state.link.is_up, "it is asked again"


async def test_locations_and_shelves_that_are_nowhere_are_left_out_and_of_two_with_one_name_the_ids_count() -> None:
    odd = [
        pb2.Location(id="L1", name="会議室 🐈", pose=pb2.Pose(x=1.0)),
        pb2.Location(id="L2", name="desk"),
        pb2.Location(id="L3", name="desk", pose=pb2.Pose(x=2.0)),
        pb2.Location(id="L4", name="nowhere", pose=pb2.Pose(x=NAN)),
        pb2.Location(id="", name="without an id"),
        pb2.Location(id="L2", name="an id twice"),
        pb2.Location(id="L5"),
    ]
    shelves = [pb2.Shelf(id="S1", name="tea", pose=pb2.Pose(theta=INF)), pb2.Shelf(id="S2", name="tea")]
    hostile = telling(
        GetLocations=pb2.GetLocationsResponse(locations=odd), GetShelves=pb2.GetShelvesResponse(shelves=shelves)
    )
    async with staged(servicer=hostile) as stage:
        layout = stage.robot.state.layout
        assert [each.id for each in layout.locations] == ["L1", "L2", "L3", "L5"]
        assert [each.id for each in layout.shelves] == ["S2"]
        things = await stage.client.component("robot/surroundings").query("things")
        assert things["name"] == ["会議室 🐈", "desk", "desk", "", "tea"]
        navigation = await stage.client.find(Navigation)
        async with navigation.bound():
            await stage.client.run(navigation.set(target_positions=["会議室 🐈", "L3"]))
            with pytest.raises(ComponentFailed, match="'desk' is the name of 2 locations: use an id, 'L2' or 'L3'"):
                await stage.client.run(navigation.set(target_positions=["desk"]))


async def test_a_map_without_a_scale_is_an_error_and_the_floor_comes_when_the_map_is_right() -> None:
    class Mending(SimulatorServicer):
        async def GetPngMap(self, request: Any, context: Any) -> Any:  # noqa: N802
            response = await SimulatorServicer.GetPngMap(self, request, context)
            self.count("map")
            if self.calls["map"] < 3:
                response.map.resolution = 0.0
            return response

    async with staged(servicer=Mending) as stage:
        with pytest.raises(ComponentFailed, match="the robot's map has no scale"):
            await stage.client.component("robot/map").query("map")
        await until(lambda: stage.robot.state.world.floor)


async def test_a_command_that_was_accepted_without_an_id_fails_and_does_not_run_on() -> None:
    class Nameless(SimulatorServicer):
        async def StartCommand(self, request: Any, context: Any) -> Any:  # noqa: N802
            response = await SimulatorServicer.StartCommand(self, request, context)
            response.command_id = ""
            return response

    async with staged(1.0, servicer=Nameless) as stage:
        navigation = await stage.client.find(Navigation)
        async with navigation.bound(), asyncio.timeout(10):
            await navigation.set(target_positions=["kitchen"])
            with pytest.raises(ComponentFailed, match="the robot has accepted to go to 'kitchen', and told no id"):
                await stage.client.run(navigation.start())
        await until(lambda: not stage.simulation.jobs)


async def test_detections_with_numbers_that_are_none_are_persons_without_a_place_and_not_too_many() -> None:
    person = pb2.OBJECT_LABEL_PERSON
    box = pb2.RegionOfInterest(x_offset=10, y_offset=10, width=20, height=20)
    objects = [
        *(pb2.ObjectDetection(label=person, roi=box, score=0.9, distance_median=each) for each in (NAN, INF, -1.0)),
        *(pb2.ObjectDetection(label=person, roi=box, score=NAN, distance_median=1.0) for _ in range(1000)),
        *(pb2.ObjectDetection(label=person, roi=box, score=0.9, distance_median=2.0) for _ in range(1000)),
    ]
    response = pb2.GetObjectDetectionResponse(metadata=pb2.Metadata(cursor=-7), objects=objects)
    info = pb2.GetFrontCameraRosCameraInfoResponse(camera_info=pb2.RosCameraInfo(width=1280, height=720, K=[NAN] * 9))
    async with staged(servicer=telling(GetObjectDetection=response, GetFrontCameraRosCameraInfo=info)) as stage:
        localization = await stage.client.find(PersonLocalization)
        async with localization.person_localized() as localized, asyncio.timeout(10):
            event = await anext(aiter(localized))
        assert 1 <= len(event.position_data) <= 50
        assert not any("nan" in each or "inf" in each for each in event.position_data)


async def test_persons_are_nowhere_while_the_robot_does_not_tell_where_it_is() -> None:
    nowhere = pb2.GetRobotPoseResponse(pose=pb2.Pose(x=NAN))
    async with staged(at=Pose(0.0, 0.2), servicer=telling(GetRobotPose=nowhere)) as stage:
        detection = await stage.client.find(PersonDetection)
        localizer: Any = next(each for each in stage.robot.components if each.name == "person_localizer")
        async with detection.person_detected() as detected, asyncio.timeout(10):
            assert (await anext(each async for each in detected if each.number)).number == 1
        assert localizer._detection.locate(Place(0.0, 1.0, 0.0)) is None


async def test_pictures_that_are_none_or_too_large_are_counted_and_the_next_one_is_shown() -> None:
    class Odd(SimulatorServicer):
        async def GetFrontCameraRosCompressedImage(self, request: Any, _context: Any) -> Any:  # noqa: N802
            pictures = (b"", b"no JPEG", resized(JPEG, 65_000, 65_000), JPEG[:40], JPEG)
            self.count("front")
            data = pictures[min(self.calls["front"], len(pictures)) - 1]
            return pb2.GetFrontCameraRosCompressedImageResponse(
                metadata=pb2.Metadata(cursor=-self.calls["front"]), image=pb2.RosCompressedImage(data=data)
            )

    async with staged(servicer=Odd) as stage:
        camera = stage.robot.cameras[VIDEO]
        async with camera.open() as pictures, asyncio.timeout(10):
            picture = await anext(pictures)
        assert (picture.width, picture.height) == (64, 48)
        assert camera.figures.unreadable == 4


async def test_answers_that_come_late_and_out_of_order_lose_no_command() -> None:
    class Late(SimulatorServicer):
        async def GetCommandState(self, request: Any, context: Any) -> Any:  # noqa: N802
            response = await SimulatorServicer.GetCommandState(self, request, context)
            self.count("late")
            await asyncio.sleep(0.25 if self.calls["late"] % 2 else 0.0)
            return response

    async with staged(servicer=Late) as stage:
        navigation = await stage.client.find(Navigation)
        async with navigation.bound(), asyncio.timeout(20):
            for target in ("1.0,0.0", "home", "1.0,0.0"):
                await navigation.set(target_positions=[target])
                await stage.client.run(navigation.start())
        assert stage.robot.commands.figures.lost == 0


async def test_an_adapter_ends_in_time_while_its_robot_hangs() -> None:
    answers = asyncio.Event()
    answers.set()

    class Hanging(SimulatorServicer):
        async def changed(self, topic: str, cursor: int) -> int:
            await answers.wait()
            return await super().changed(topic, cursor)

    async with asyncio.timeout(10):
        async with staged(1.0, servicer=Hanging) as stage:
            navigation = await stage.client.find(Navigation)
            await navigation.bind()
            await navigation.set(target_positions=["kitchen"])
            going = asyncio.ensure_future(stage.client.run(navigation.start()))
            await until(lambda: stage.simulation.jobs)
            answers.clear()
    assert await ended(going) is not None
