"""The vendor's own client, blocking and asynchronous, works with the simulated robot."""

import asyncio
from collections.abc import Callable
from typing import Any

import kachaka_api
import kachaka_api.aio
import pytest
from kachaka_api.generated import kachaka_api_pb2 as pb2
from openrois_robots.kachaka.simulator.servicer import SimulatorServicer

from tests.support.kachaka import simulated


async def with_asyncio(client: kachaka_api.aio.KachakaApiClient) -> dict[str, Any]:
    """Do with the asynchronous client what `blocking` does."""
    seen: dict[str, Any] = {"serial": await client.get_robot_serial_number()}
    seen["version"] = await client.get_robot_version()
    seen["battery"] = await client.get_battery_info()
    await client.update_resolver()
    seen["move"] = await client.move_to_location("kitchen")
    seen["pose"] = await client.get_robot_pose()
    seen["forward"] = await client.move_forward(-0.2)
    seen["turn"] = await client.rotate_in_place(0.5)
    seen["speak"] = await client.speak("hello")
    seen["shelf"] = await client.move_shelf("tea shelf", "sofa")
    seen["nowhere"] = await client.move_to_pose(100, 100, 0)
    seen["home"] = await client.return_home()
    seen["running"] = await client.is_command_running()
    seen["velocity"] = await client.set_robot_velocity(0.1, 0.2)
    await client.set_robot_stop()  # type: ignore[no-untyped-call]
    seen["image"] = await client.get_front_camera_ros_compressed_image()
    seen["detection"] = await client.get_object_detection()
    seen["map"] = await client.get_png_map()
    seen["errors"] = await client.get_error()
    seen["texts"] = await client.get_robot_error_code()
    seen["volume"] = (await client.set_speaker_volume(7), await client.get_speaker_volume())
    return seen


def blocking(client: kachaka_api.KachakaApiClient) -> dict[str, Any]:
    """Do with the blocking client what `with_asyncio` does."""
    seen: dict[str, Any] = {"serial": client.get_robot_serial_number()}
    seen["version"] = client.get_robot_version()
    seen["battery"] = client.get_battery_info()
    client.update_resolver()
    seen["move"] = client.move_to_location("kitchen")
    seen["pose"] = client.get_robot_pose()
    seen["forward"] = client.move_forward(-0.2)
    seen["turn"] = client.rotate_in_place(0.5)
    seen["speak"] = client.speak("hello")
    seen["shelf"] = client.move_shelf("tea shelf", "sofa")
    seen["nowhere"] = client.move_to_pose(100, 100, 0)
    seen["home"] = client.return_home()
    seen["running"] = client.is_command_running()
    seen["velocity"] = client.set_robot_velocity(0.1, 0.2)
    client.set_robot_stop()  # type: ignore[no-untyped-call]
    seen["image"] = client.get_front_camera_ros_compressed_image()
    seen["detection"] = client.get_object_detection()
    seen["map"] = client.get_png_map()
    seen["errors"] = client.get_error()
    seen["texts"] = client.get_robot_error_code()
    seen["volume"] = (client.set_speaker_volume(7), client.get_speaker_volume())
    return seen


@pytest.mark.parametrize("kind", ["asyncio", "blocking"])
async def test_it_does_all_that_an_adapter_uses(kind: str) -> None:
    async with simulated() as (servicer, address):
        if kind == "asyncio":
            client = kachaka_api.aio.KachakaApiClient(address.text)
            seen = await with_asyncio(client)
        else:
            seen = await asyncio.to_thread(lambda: blocking(kachaka_api.KachakaApiClient(address.text)))
        for done in ("move", "forward", "turn", "speak", "shelf", "home", "velocity"):
            assert seen[done].success, done
        assert (seen["serial"], seen["version"]) == ("SIMULATED", "3.17.5")
        assert seen["battery"] == (pytest.approx(80, abs=2), pb2.POWER_SUPPLY_STATUS_CHARGING)
        assert (seen["pose"].x, seen["pose"].y) == (pytest.approx(5.5), pytest.approx(1.5))
        assert not seen["nowhere"].success
        assert seen["texts"][seen["nowhere"].error_code].title == "No way"
        assert not seen["running"]
        assert seen["image"].data.startswith(b"\xff\xd8")
        assert all(each.label == pb2.OBJECT_LABEL_PERSON for each in seen["detection"][1])
        assert seen["map"].data.startswith(b"\x89PNG")
        assert list(seen["errors"]) == []
        assert seen["volume"][0].success
        assert seen["volume"][1] == 7
        assert servicer.robot.premises.shelf_poses["S01"].x == pytest.approx(4.5)
        assert not servicer.robot.manual.is_on(servicer.robot.now)


async def test_a_motion_is_cancelled() -> None:
    async with simulated(1.0) as (servicer, address):
        client = kachaka_api.aio.KachakaApiClient(address.text)
        going = asyncio.ensure_future(client.move_forward(3.0))
        while not servicer.robot.jobs:  # noqa: ASYNC110 - it tells of no event
            await asyncio.sleep(0.01)
        result, command = await client.cancel_command()
        assert result.success
        assert command.HasField("move_forward_command")
        assert not (await going).success


async def test_what_it_does_not_have_is_unimplemented() -> None:
    async with simulated() as (_, address):
        client = kachaka_api.aio.KachakaApiClient(address.text)
        with pytest.raises(Exception, match="UNIMPLEMENTED"):
            await client.get_ros_imu()


async def counted(client: kachaka_api.aio.KachakaApiClient, enough: Callable[[], bool]) -> int:
    """Return the pictures that the vendor's stream brings until it is enough."""
    pictures = 0
    async for _ in client.front_camera_ros_compressed_image.stream():
        pictures += 1
        if enough():
            return pictures
    raise AssertionError("the stream has no end")


async def test_pictures_are_waited_for_by_their_cursors() -> None:
    async with simulated() as (servicer, address):
        client = kachaka_api.aio.KachakaApiClient(address.text)
        pictures = await counted(client, lambda: servicer.calls["front"] >= 10)
        assert pictures == 10, "each answer is another picture"


async def test_a_servicer_says_at_once_where_it_cannot_listen() -> None:
    from openrois_robots.kachaka.simulator.robot import RobotSettings, SimulatedKachaka
    from openrois_robots.kachaka.simulator.servicer import serve_simulator

    async with simulated() as (_, address):
        other = SimulatorServicer(SimulatedKachaka(RobotSettings()))
        with pytest.raises(OSError, match="nothing can listen at"):
            async with serve_simulator(other, port=address.port):
                pass
