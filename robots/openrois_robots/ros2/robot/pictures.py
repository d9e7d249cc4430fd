"""Pictures of ROS messages as arrays, and a camera's topic as a source of video."""

import asyncio
from collections.abc import AsyncGenerator, Callable, Mapping
from types import MappingProxyType
from typing import Any, Final

import cv2
import numpy as np
from numpy.typing import NDArray
from openrois_media import VideoSource
from openrois_streaming.clock import MediaClock

from openrois_robots.adapter.image_files import MOST_PIXELS, ImageFileError, decode_image
from openrois_robots.ros2.graph.backend import RosBackend
from openrois_robots.ros2.graph.matching import Qos
from openrois_robots.ros2.mapping.settings import IMAGES, Camera
from openrois_robots.ros2.robot.poses import image_time

__all__ = ["PATIENCE", "PictureError", "camera_source", "decode_compressed", "decode_raw"]

PATIENCE: Final = 5.0
"""Seconds within which a watched camera has to give a picture."""
_CHANNELS: Final[Mapping[str, int]] = MappingProxyType({"rgb8": 3, "bgr8": 3, "rgba8": 4, "bgra8": 4, "mono8": 1})
"""The encodings of `sensor_msgs/msg/Image` that are read, and the bytes of a pixel."""


class PictureError(RuntimeError):
    """A message that is no picture, or a camera without pictures; the text says why."""


def decode_compressed(message: Any) -> NDArray[np.uint8]:
    """Return the picture of a `CompressedImage` as bgr24, of shape (height, width, 3).

    Raises:
        PictureError: its data is none that is read here (JPEG, PNG), or is too large.
    """
    data = _bytes(message.data)
    try:
        return decode_image(data)
    except ImageFileError as error:
        said = f"a picture of the format {message.format[:40]!r} with {len(data)} bytes cannot be read: {error}"
        raise PictureError(said) from None


def decode_raw(message: Any) -> NDArray[np.uint8]:
    """Return the picture of an `Image` as bgr24, of shape (height, width, 3).

    Raises:
        PictureError: its encoding is not read here, or it has fewer bytes than it says.
    """
    channels = _CHANNELS.get(message.encoding)
    if channels is None:
        raise PictureError(
            f"pictures of the encoding {message.encoding[:40]!r} cannot be read; there are {', '.join(_CHANNELS)}"
        )
    height, width, step = message.height, message.width, message.step
    data = np.frombuffer(_bytes(message.data), np.uint8)
    fits = 0 < width * height <= MOST_PIXELS and step >= width * channels and data.size >= step * height
    if not fits:
        raise PictureError(f"a picture of {width}x{height} with rows of {step} bytes cannot have {data.size} bytes")
    rows = data[: step * height].reshape(height, step)[:, : width * channels]
    pixels = np.ascontiguousarray(rows.reshape(height, width, channels))
    match message.encoding:
        case "bgr8":
            return pixels
        case "rgb8":
            return np.asarray(cv2.cvtColor(pixels, cv2.COLOR_RGB2BGR), np.uint8)
        case "rgba8":
            return np.asarray(cv2.cvtColor(pixels, cv2.COLOR_RGBA2BGR), np.uint8)
        case "bgra8":
            return np.asarray(cv2.cvtColor(pixels, cv2.COLOR_BGRA2BGR), np.uint8)
    return np.asarray(cv2.cvtColor(pixels, cv2.COLOR_GRAY2BGR), np.uint8)


def camera_source(backend: RosBackend, name: str, camera: Camera, clock: MediaClock) -> VideoSource:
    """Return the pictures of a topic, which is subscribed to while an application watches, and at no other time.

    The newest picture is decoded, in a thread; those that come meanwhile are left out, and so are pictures that cannot
    be read, unless there are no others for `PATIENCE` seconds.

    Args:
        backend: the graph.
        name: of the camera.
        camera: its settings.
        clock: the media clock.
    """
    decode = decode_compressed if camera.type == IMAGES[0] else decode_raw

    async def pictures() -> AsyncGenerator[tuple[NDArray[np.uint8], float], None]:
        newest: asyncio.Queue[tuple[Any, float]] = asyncio.Queue(1)

        def receive(message: Any) -> None:
            if newest.full():
                newest.get_nowait()
            newest.put_nowait((message, image_time(message.header.stamp, clock.now(), clock.wall())))

        qos = Qos("reliable" if camera.reliability == "reliable" else "best_effort", "volatile", 1)
        subscription = backend.subscribe(camera.topic, camera.type, qos, receive)
        read_at = clock.now()
        try:
            while True:
                message, taken_at = await _within(newest.get, lambda: subscription.problem, camera.topic, clock)
                try:
                    picture = await asyncio.to_thread(decode, message)
                except PictureError:
                    if clock.now() - read_at > PATIENCE:
                        raise
                    continue
                read_at = clock.now()
                yield picture, taken_at
        finally:
            subscription.close()

    size = camera.width, camera.height
    return VideoSource(pictures, size=size, frame_rate=camera.frame_rate, clock=clock, name=name)


async def _within(
    get: Callable[[], Any], problem: Callable[[], str], topic: str, clock: MediaClock
) -> tuple[Any, float]:
    """Return the next picture.

    Raises:
        PictureError: none came in time.
    """
    getting = asyncio.ensure_future(get())
    late = asyncio.ensure_future(clock.sleep_until(clock.now() + PATIENCE))
    try:
        await asyncio.wait({getting, late}, return_when=asyncio.FIRST_COMPLETED)
        if not getting.done():
            raise PictureError(problem() or f"no picture came on {topic} for {PATIENCE:g} s")
        result: tuple[Any, float] = getting.result()
        return result
    finally:
        getting.cancel()
        late.cancel()
        await asyncio.wait({getting, late})


def _bytes(data: Any) -> bytes:
    return data if isinstance(data, bytes) else bytes(data)
