"""Pictures of cameras and encoders: what is made of them, and what is refused."""

import re
from collections.abc import AsyncIterator, Sequence
from typing import Any

import numpy as np
import pytest
from openrois_streaming.capture.moments import OLDEST
from openrois_streaming.capture.video import EncodedSource, Picture, VideoSource
from openrois_streaming.publish.video_encoder import VideoEncoder
from openrois_streaming.rtp.h264_units import NotPassable
from openrois_streaming.source.source import PixelFormat, RawVideo, picture_shape
from openrois_streaming.synthetic import ColourBars

from tests.support.streaming import VirtualClock


def pixels(pixel_format: PixelFormat = "bgr24", width: int = 64, height: int = 32) -> Any:
    return np.zeros(picture_shape(pixel_format, width, height), np.uint8)


def camera(*pictures: Any, format: PixelFormat = "bgr24") -> VideoSource:
    async def given() -> AsyncIterator[Picture]:
        for picture in pictures:
            yield picture

    return VideoSource(given, size=(64, 32), format=format, clock=VirtualClock(), name="the porch")


async def taken(source: VideoSource) -> list[RawVideo]:
    async with source.open() as frames:
        return [frame async for frame in frames]


@pytest.mark.parametrize("pixel_format", ["bgra", "bgr24", "rgb24", "nv12", "i420"])
async def test_arrays_become_pictures_of_their_size(pixel_format: PixelFormat) -> None:
    data = pixels(pixel_format)
    first, second = await taken(camera(data, pixels(pixel_format, 32, 16), format=pixel_format))
    assert first.data is data
    assert (first.format, first.width, first.height, first.sequence) == (pixel_format, 64, 32, 0)
    assert (second.width, second.height, second.sequence) == (32, 16, 1)


async def test_a_picture_has_the_moment_that_it_is_given_or_that_at_which_it_came() -> None:
    frames = await taken(camera(pixels(), (pixels(), 999.25), (pixels(), 1000)))
    assert [frame.captured_at for frame in frames] == [1000.0, 999.25, 1000.0]


@pytest.mark.parametrize("moment", [1_800_000_000.0, 1000 - OLDEST - 1, 1002.0, float("nan")])
async def test_a_moment_of_another_clock_is_refused(moment: float) -> None:
    with pytest.raises(ValueError, match=r"the porch gave .* must be in seconds of time.monotonic\(\), .* 1000.000"):
        await taken(camera((pixels(), moment)))


@pytest.mark.parametrize(
    ("wrong", "error", "text"),
    [
        (None, TypeError, "as numpy arrays, not NoneType"),
        ([[0]], TypeError, "as numpy arrays, not list"),
        (np.zeros((32, 64), np.uint8), ValueError, "shape (height, width, channels), not (32, 64)"),
        (np.zeros((32, 64, 4), np.uint8), ValueError, "64x32 bgr24 picture cannot be uint8 (32, 64, 4)"),
        (np.zeros((32, 64, 3), np.float32), ValueError, "cannot be float32"),
        ((np.zeros((32, 64, 3), np.uint8), "now"), TypeError, "a frame, or a frame and its time of capture"),
        ((np.zeros((32, 64, 3), np.uint8), 1000.0, 3), TypeError, "a frame, or a frame and its time of capture"),
    ],
)
async def test_what_is_no_picture_is_refused_with_its_source(wrong: Any, error: type[Exception], text: str) -> None:
    with pytest.raises(error, match=re.escape(text)):
        await taken(camera(wrong))


async def test_a_media_source_is_taken_as_it_is() -> None:
    bars = ColourBars(160, 90, clock=VirtualClock())
    async with VideoSource(bars, size=(160, 90)).open() as frames:
        assert (await anext(frames)).sequence == 0


def encoded(mime_type: str, sizes: Sequence[tuple[int, int]] = ((64, 32),)) -> list[bytes]:
    """A key frame of each size, and a picture after it."""
    units = []
    for size in sizes:
        encoder = VideoEncoder(mime_type, bitrate=200_000, frame_rate=30)
        for number in range(2):
            raw = RawVideo(pixels("i420", *size), "i420", *size, number, 1000 + number / 30)
            units += [chunk.data for chunk in encoder.encode(raw, key_frame=number == 0)]
    return units


@pytest.mark.parametrize("mime_type", ["video/H264", "video/VP8"])
async def test_an_encoded_picture_says_whether_it_is_a_key_frame_and_how_large_it_is(mime_type: str) -> None:
    units = encoded(mime_type, [(64, 32), (160, 96)])
    source = EncodedSource(lambda: iter(units), size=(2, 2), mime_type=mime_type, clock=VirtualClock())
    async with source.open() as frames:
        found = [(frame.data, frame.keyframe, frame.width, frame.height) async for frame in frames]
    sizes = [(True, 64, 32), (False, 64, 32), (True, 160, 96), (False, 160, 96)]
    assert found == [(unit, *each) for unit, each in zip(units, sizes, strict=True)]


async def test_what_the_viewers_need_is_passed_to_the_encoder() -> None:
    asked: list[Any] = []
    source = EncodedSource(
        lambda: iter([]),
        size=(64, 32),
        request_key_frame=lambda: asked.append("key frame"),
        set_bitrate=asked.append,
        clock=VirtualClock(),
    )
    source.request_key_frame()
    source.set_bitrate(700_000)
    assert asked == ["key frame", 700_000]


@pytest.mark.parametrize(
    ("mime_type", "wrong", "error", "text"),
    [
        ("video/H264", "text", TypeError, "encoded pictures as bytes, not str"),
        ("video/H264", b"\0\0\0\1\x68\0", NotPassable, "no picture"),
        ("video/VP8", b"\0\0", NotPassable, "more than 3 bytes"),
        ("video/VP8", bytes(20), NotPassable, "no start code"),
    ],
)
async def test_what_no_viewer_can_decode_is_refused(
    mime_type: str, wrong: Any, error: type[Exception], text: str
) -> None:
    source = EncodedSource(lambda: iter([wrong]), size=(64, 32), mime_type=mime_type, clock=VirtualClock())
    async with source.open() as frames:
        with pytest.raises(error, match=text):
            await anext(frames)


def test_another_codec_is_refused() -> None:
    with pytest.raises(ValueError, match="must come encoded as video/H264 or video/VP8, not as 'video/AV1'"):
        EncodedSource(lambda: iter([]), size=(64, 32), mime_type="video/AV1")


@pytest.mark.parametrize(
    ("wrong", "error", "text"),
    [
        (
            {"size": (0, 32)},
            ValueError,
            "size of the porch must be a width and height of 2 or more pixels, not (0, 32)",
        ),
        ({"size": "64x32"}, ValueError, "not '64x32'"),
        ({"size": (64, 32, 3)}, ValueError, "not (64, 32, 3)"),
        ({"size": (64.5, 32)}, ValueError, "not (64.5, 32)"),
        ({"frame_rate": 0}, ValueError, "frame_rate of the porch must be pictures per second, up to 1000, not 0"),
        ({"frame_rate": float("nan")}, ValueError, "not nan"),
    ],
)
@pytest.mark.parametrize("kind", [VideoSource, EncodedSource])
def test_what_no_camera_has_is_refused_at_once(kind: Any, wrong: Any, error: type[Exception], text: str) -> None:
    with pytest.raises(error, match=re.escape(text)):
        kind(lambda: iter([]), **{"size": (64, 32), "name": "the porch", **wrong})


def test_pictures_in_a_format_that_is_not_known_are_refused_at_once() -> None:
    with pytest.raises(ValueError, match="format of camera must be one of bgra, bgr24, rgb24, nv12, i420, not 'rgb'"):
        VideoSource(lambda: iter([]), size=(64, 32), format="rgb")  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="i420 needs an even width and height"):
        VideoSource(lambda: iter([]), size=(63, 32), format="i420")


@pytest.mark.parametrize("kind", [VideoSource, EncodedSource])
def test_an_iterator_in_place_of_its_function_is_refused_at_once(kind: Any) -> None:
    with pytest.raises(
        TypeError, match=r"camera must be a function that returns an iterator, not a .*: do not call it"
    ):
        kind((number for number in range(3)), size=(64, 32))
