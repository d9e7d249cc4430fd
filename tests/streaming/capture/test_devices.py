"""Cameras, as far as they can be had without one: video files and generated pictures, by the same calls."""

import asyncio
import re
from pathlib import Path

import av
import cv2
import numpy as np
import pytest
from openrois_streaming.capture.devices import CameraFailed, ffmpeg_input, opencv_camera, v4l2_camera


@pytest.fixture
def film(tmp_path: Path) -> Path:
    """Ten pictures, blue above and red below."""
    path = tmp_path / "film.avi"
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"MJPG"), 30, (64, 48))
    picture = np.zeros((48, 64, 3), np.uint8)
    picture[:24, :, 0] = picture[24:, :, 2] = 200
    for _ in range(10):
        writer.write(picture)
    writer.release()
    return path


async def test_opencv_gives_what_it_reads_and_says_when_there_is_no_more(film: Path) -> None:
    async with asyncio.timeout(30), opencv_camera(str(film), size=(64, 48)).open() as frames:
        first = await anext(frames)
        assert (first.width, first.height, first.format) == (64, 48, "bgr24")
        assert first.data[2, 2, 0] > 150 > 60 > first.data[2, 2, 2]
        text = f"the camera '{film}' gives no pictures any more: connect it again"
        with pytest.raises(CameraFailed, match=re.escape(text)):
            [frame async for frame in frames]


async def test_a_camera_that_opencv_cannot_open_is_named(tmp_path: Path) -> None:
    async with asyncio.timeout(30), opencv_camera(str(tmp_path / "none")).open() as frames:
        with pytest.raises(CameraFailed, match=r"OpenCV cannot open the camera '.*none': is it connected"):
            await anext(frames)


async def test_the_libraries_of_ffmpeg_give_even_pictures_in_limited_range(film: Path) -> None:
    async with asyncio.timeout(30), ffmpeg_input(str(film)).open() as frames:
        first = await anext(frames)
        assert (first.width, first.height, first.format) == (64, 48, "i420")
        luma, u = first.data[:48], first.data.reshape(-1)[64 * 48 :][: 32 * 24].reshape(24, 32)
        assert luma[2, 2] == pytest.approx(16 + 0.098 * 200, abs=6)
        assert u[2, 2] > 180
        with pytest.raises(CameraFailed, match="has ended"):
            [frame async for frame in frames]


async def test_an_input_that_ffmpeg_cannot_open_is_named(tmp_path: Path) -> None:
    (tmp_path / "text").write_text("no film")
    for path in (tmp_path / "none", tmp_path / "text"):
        async with asyncio.timeout(30), ffmpeg_input(str(path)).open() as frames:
            with pytest.raises(CameraFailed, match=f"{re.escape(str(path))} cannot be opened"):
                await anext(frames)


async def test_an_input_with_sound_alone_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "sound.wav"
    with av.open(str(path), "w") as container:
        stream = container.add_stream("pcm_s16le", rate=48_000)
        frame = av.AudioFrame.from_ndarray(np.zeros((1, 480), np.int16), "s16", "mono")
        frame.sample_rate = 48_000
        container.mux(stream.encode(frame))
    async with asyncio.timeout(30), ffmpeg_input(str(path)).open() as frames:
        with pytest.raises(CameraFailed, match="has no pictures"):
            await anext(frames)


async def test_a_camera_of_video4linux_that_is_not_there_is_named() -> None:
    async with asyncio.timeout(30), v4l2_camera("/dev/video-none").open() as frames:
        with pytest.raises(CameraFailed, match=r"/dev/video-none cannot be opened: .*No such file"):
            await anext(frames)
