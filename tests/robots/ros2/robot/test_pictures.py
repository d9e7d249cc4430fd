"""Pictures of messages, and a camera's topic as a source."""

import asyncio
from typing import Any

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from openrois_robots.ros2.mapping.settings import IMAGES, Camera
from openrois_robots.ros2.robot.pictures import PATIENCE, PictureError, camera_source, decode_compressed, decode_raw

from tests.support.image_files import JPEG, resized
from tests.support.ros_robot import FakeGraph, message
from tests.support.streaming import VirtualClock, settle

pytestmark = pytest.mark.extra(name="ros2")

RED = (20, 30, 200)
"""Blue, green and red."""


def picture(width: int = 8, height: int = 4) -> Any:
    """Return a red picture with a blue pixel in its first row, as bgr24."""
    made = np.full((height, width, 3), RED, np.uint8)
    made[0, 1] = (255, 0, 0)
    return made


def image(encoding: str, data: bytes, *, width: int = 8, height: int = 4, step: int = 0, at: float = 0.0) -> Any:
    stamp = {"sec": int(at), "nanosec": round(at % 1 * 1e9)}
    step = step or width * {"mono8": 1, "rgba8": 4, "bgra8": 4}.get(encoding, 3)
    header = {"stamp": stamp, "frame_id": "camera"}
    return message(header=header, encoding=encoding, width=width, height=height, step=step, data=data)


@pytest.mark.parametrize(
    ("encoding", "conversion"),
    [
        ("bgr8", None),
        ("rgb8", cv2.COLOR_BGR2RGB),
        ("bgra8", cv2.COLOR_BGR2BGRA),
        ("rgba8", cv2.COLOR_BGR2RGBA),
    ],
)
@pytest.mark.parametrize("kind", [bytes, list])
def test_encodings_become_bgr(encoding: str, conversion: int | None, kind: Any) -> None:
    data = picture() if conversion is None else cv2.cvtColor(picture(), conversion)
    assert (decode_raw(image(encoding, kind(data.tobytes()))) == picture()).all()


def test_grey_pictures_stay_grey() -> None:
    read = decode_raw(image("mono8", bytes(range(32))))
    assert read.shape == (4, 8, 3)
    assert (read[1, 2] == 10).all()


def test_rows_may_be_longer_than_their_pixels() -> None:
    rows = b"".join(row.tobytes() + b"\xaa" * 5 for row in picture())
    assert (decode_raw(image("bgr8", rows, step=29)) == picture()).all()


@pytest.mark.parametrize(
    ("told", "said"),
    [
        (image("16UC1", b""), "the encoding '16UC1' cannot be read; there are rgb8, bgr8"),
        (image("bgr8", bytes(95)), "a picture of 8x4 with rows of 24 bytes cannot have 95 bytes"),
        (image("bgr8", bytes(96), step=23), "with rows of 23 bytes"),
        (image("bgr8", b"", width=0, step=3), "a picture of 0x4"),
        (image("bgr8", b"", width=100_000, height=100_000), "a picture of 100000x100000"),
    ],
)
def test_what_is_no_picture_is_said(told: Any, said: str) -> None:
    with pytest.raises(PictureError, match=said):
        decode_raw(told)


def test_a_jpeg_and_a_png_are_decoded() -> None:
    for extension in (".jpg", ".png"):
        data = cv2.imencode(extension, picture(64, 48))[1].tobytes()
        read = decode_compressed(message(format=extension, data=data))
        assert read.shape == (48, 64, 3)
        assert np.abs(read[40, 40].astype(int) - RED).max() < 12


def test_a_picture_that_says_it_is_huge_is_not_decoded(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delattr(cv2, "imdecode")
    with pytest.raises(PictureError, match=r"'jpeg' with .* read: a picture of 65000x65000 is not read"):
        decode_compressed(message(format="jpeg", data=resized(JPEG, 65_000, 65_000)))


async def test_pictures_that_cannot_be_read_are_left_out_and_end_a_camera_that_gives_no_others() -> None:
    graph, clock = FakeGraph(), VirtualClock()
    source = camera_source(graph, "front", Camera("/camera", IMAGES[1], width=8, height=4), clock)

    async def said(data: bytes, seconds: float) -> None:
        for _ in range(round(seconds / 0.5)):
            graph.say("/camera", image("bgr8", data, at=clock.wall()))
            await settle()
            await asyncio.sleep(0.01)
            await clock.advance(0.5)

    async with source.open() as pictures:
        coming = pictures.__aiter__()
        waiting = asyncio.ensure_future(coming.__anext__())
        await settle()
        await said(bytes(95), PATIENCE / 2)
        assert not waiting.done()
        await said(bytes(96), 0.5)
        assert (await waiting).width == 8
        waiting = asyncio.ensure_future(coming.__anext__())
        await settle()
        await said(bytes(95), PATIENCE + 1.0)
        with pytest.raises(PictureError, match="cannot have 95 bytes"):
            await waiting


@given(st.binary(max_size=64))
def test_what_is_no_jpeg_is_said(data: bytes) -> None:
    with pytest.raises(PictureError, match="a picture of the format 'jpeg' with"):
        decode_compressed(message(format="jpeg", data=data))


async def test_a_watched_camera_gives_its_newest_picture_with_its_time_and_an_unwatched_one_is_left_alone() -> None:
    graph, clock = FakeGraph(), VirtualClock()
    camera = Camera("/camera", IMAGES[1], width=8, height=4)
    source = camera_source(graph, "front", camera, clock)
    assert graph.subscriptions == []
    async with source.open() as pictures:
        coming = pictures.__aiter__()
        waiting = asyncio.ensure_future(coming.__anext__())
        await settle()
        end = graph.subscriptions[0][0]
        assert end.qos is not None
        assert (end.name, end.qos.reliability, end.qos.depth) == ("/camera", "best_effort", 1)
        graph.say("/camera", image("bgr8", bytes(96), at=clock.wall() - 0.2))
        graph.say("/camera", image("bgr8", picture().tobytes(), at=clock.wall() - 0.1))
        frame = await waiting
        assert (frame.data == picture()).all()
        assert frame.captured_at == pytest.approx(clock.now() - 0.1, abs=1e-3)
    assert end.is_closed


@pytest.mark.parametrize(
    ("problem", "said"),
    [
        ("", f"no picture came on /camera for {PATIENCE:g} s"),
        ("/camera is published best_effort, and the mapping file has reliable", ""),
    ],
)
async def test_a_camera_without_pictures_fails_with_the_reason(problem: str, said: str) -> None:
    graph, clock = FakeGraph(), VirtualClock()
    if problem:
        graph.problems["/camera"] = problem
    source = camera_source(graph, "front", Camera("/camera", reliability="reliable"), clock)
    async with source.open() as pictures:
        waiting = asyncio.ensure_future(pictures.__aiter__().__anext__())
        await clock.advance(PATIENCE + 0.1)
        with pytest.raises(PictureError, match=said or problem):
            await waiting
    assert graph.subscriptions[0][0].is_closed
