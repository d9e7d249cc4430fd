"""What aiortc's sender gets of an application's frames."""

import asyncio
from fractions import Fraction

import av
import numpy as np
import pytest
from aiortc.mediastreams import MediaStreamError
from openrois_streaming.source.source import PixelFormat, RawAudio, RawVideo
from openrois_streaming.viewing.outgoing import WAITING_LIMIT, OutgoingTrack

from tests.support.streaming import picture, settle


async def test_a_picture_keeps_its_pixels_and_its_time() -> None:
    track = OutgoingTrack("video")
    pixels = np.random.default_rng(1).integers(0, 255, (24, 16), np.uint8)
    for moment in (7.0, 7.5):
        track.put(RawVideo(pixels, "i420", 16, 16, 0, moment))
        frame = await track.recv()
    assert (frame.format.name, frame.pts, frame.time_base) == ("yuv420p", 45_000, Fraction(1, 90_000))
    assert np.array_equal(frame.to_ndarray(), pixels)


@pytest.mark.parametrize(("pixel_format", "depth"), [("bgr24", 3), ("bgra", 4)])
async def test_other_formats(pixel_format: PixelFormat, depth: int) -> None:
    track = OutgoingTrack("video")
    pixels = np.random.default_rng(1).integers(0, 255, (16, 32, depth), np.uint8)[:, ::2]
    track.put(RawVideo(pixels, pixel_format, 16, 16, 0, 7.0))
    frame = await track.recv()
    assert np.array_equal(frame.to_ndarray(), pixels)


async def test_an_encoder_that_is_late_gets_the_newest_picture() -> None:
    track = OutgoingTrack("video")
    for number in range(3):
        track.put(picture(number, float(number)))
    assert (await track.recv()).pts == 0
    track.put(picture(3, 3.0))
    track.clear()
    waiting = asyncio.ensure_future(track.recv())
    await settle()
    assert not waiting.done()
    track.put(picture(4, 4.0))
    assert (await waiting).pts == 2 * 90_000


async def test_sound_has_timestamps_without_a_gap() -> None:
    track = OutgoingTrack("audio")
    for number, channels in enumerate((1, 2)):
        track.put(RawAudio(np.full((480, channels), number, np.int16), 10.0 * number))
    first, second = await track.recv(), await track.recv()
    assert isinstance(first, av.AudioFrame)
    assert isinstance(second, av.AudioFrame)
    assert (first.pts, second.pts, second.sample_rate) == (0, 480, 48_000)
    assert (first.layout.name, second.layout.name) == ("mono", "stereo")
    assert WAITING_LIMIT["audio"] >= 2


async def test_a_stopped_track_ends_its_reader() -> None:
    track = OutgoingTrack("video")
    waiting = asyncio.ensure_future(track.recv())
    await settle()
    track.stop()
    with pytest.raises(MediaStreamError):
        await waiting
