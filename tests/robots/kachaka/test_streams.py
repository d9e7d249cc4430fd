"""The Kachaka behind a real gateway: its cameras at a viewer, and faces that are seen in their pictures."""

import asyncio

import numpy as np
import pytest
from numpy.typing import NDArray
from openrois_media import Media
from openrois_robots.kachaka.adapter import BACK_VIDEO, VIDEO
from openrois_robots.kachaka.simulator.house import Pose
from openrois_streaming.source import stamp

from openrois.client import Client
from openrois.client.components import FaceDetection, VideoStreaming
from tests.support.kachaka import linked, simulator_process
from tests.support.kachaka_home import home, housed
from tests.support.people import Sitter
from tests.support.people import picture as photographed
from tests.support.robots import until

pytestmark = pytest.mark.media

SIZE = 640, 360
RATE = 15.0
"""Pictures a second: half of a real camera's, because robot, adapter, gateway and viewer share a small machine here."""
ENOUGH = 90
"""Pictures of the camera within which a share is told."""


def numbered(_pose: Pose, number: int, _name: str) -> NDArray[np.uint8]:
    """Draw a picture that changes, with its number in it."""
    picture = np.full((SIZE[1], SIZE[0], 3), 120, np.uint8)
    at = number * 8 % (SIZE[0] - 60)
    picture[100:160, at : at + 60] = (40, 60, 220)
    stamp.write(picture, number, 0.0)
    return picture


async def test_a_viewer_gets_nine_of_ten_distinct_pictures_and_without_one_none_is_fetched() -> None:
    async with home(numbered, RATE) as house:
        front = house.robot.cameras[VIDEO]
        assert "front" not in house.servicer.calls
        # A machine that is busy with other things loses pictures for a while, and the first second adapts yet:
        # what the chain itself loses it loses at all times.
        async with (
            asyncio.timeout(90),
            Client(house.url) as client,
            Media(client) as media,
            media.frames(f"kachaka/{VIDEO}", "i420") as frames,
        ):
            seen: set[int] = set()
            share = 0.0
            async for frame in frames:
                if (found := stamp.read(frame.data[: frame.height])) is not None:
                    seen = {each for each in seen if each > found.number - ENOUGH} | {found.number}
                    share = max(share, len(seen) / ENOUGH)
                if share >= 0.9:
                    break
        print(f"{share:.1%} of {ENOUGH} distinct pictures reached the viewer")
        await until(lambda: not front.is_open)
        calls = house.servicer.calls["front"]
        assert front.figures.fetched <= calls
        assert front.figures.unreadable == 0
        assert "back" not in house.servicer.calls
        await until(lambda: house.robot.state.link.is_up)
        assert house.servicer.calls["front"] == calls, "nothing is fetched any more"


@pytest.mark.long
async def test_pictures_come_again_by_themselves_when_the_robot_was_restarted() -> None:
    async with (
        simulator_process() as robot,
        housed(linked(robot.address, "kachaka")) as (url, _),
        asyncio.timeout(90),
        Client(url) as client,
        Media(client) as media,
        media.frames(f"kachaka/{VIDEO}", "i420") as frames,
    ):
        coming = aiter(frames)
        await anext(coming)
        await robot.kill()
        await robot.start_again()
        for _ in range(30):
            await anext(coming)


async def test_the_back_camera_is_a_stream_of_its_own() -> None:
    async with home() as house, Client(house.url) as client, Media(client) as media:
        picture = await media.snapshot(f"kachaka/{BACK_VIDEO}", "rgb24", timeout=60)
        assert picture.shape == (720, 1280, 3)
        assert picture.std() > 10
        assert "front" not in house.servicer.calls


async def test_faces_are_seen_in_the_pictures_of_its_camera() -> None:
    photo = photographed([Sitter("collins", size=0.25)], *SIZE)
    async with home(lambda _pose, _number, _name: photo) as house, Client(house.url) as client:
        detection = await client.find(FaceDetection)
        async with asyncio.timeout(60), detection.face_detected() as detected:
            async for event in detected:
                if event.number == 1:
                    break
        await until(lambda: not house.robot.cameras[VIDEO].is_open)


async def test_a_stream_of_a_robot_that_is_lost_is_no_success() -> None:
    async with home() as house, Client(house.url) as client:
        house.robot.state.link._judge("the robot is gone")
        camera = client.component(f"kachaka/{VIDEO}")
        assert isinstance(await client.find(VideoStreaming, condition="component_ref LIKE '%back'"), VideoStreaming)
        assert (await camera.query("component_status"))["status"] == "ERROR"
