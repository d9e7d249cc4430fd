"""The cameras of the robot as sources of pictures: fetched by long polls while they are watched, and only then."""

import asyncio
from collections.abc import AsyncGenerator, AsyncIterator, Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import aclosing, asynccontextmanager
from dataclasses import dataclass
from typing import Any, Final, Self

import numpy as np
from numpy.typing import NDArray
from openrois_streaming.clock import MediaClock
from openrois_streaming.source.fanout import Fanout, SourceEnded, Subscription
from openrois_streaming.source.source import RawVideo

from openrois_robots.adapter.image_files import ImageFileError, decode_image
from openrois_robots.kachaka.api.calls import KachakaApi
from openrois_robots.kachaka.api.polling import Poll

__all__ = ["BACK", "FRAME_RATE", "FRONT", "SIZE", "CameraFigures", "RobotCamera"]

FRONT: Final = "GetFrontCameraRosCompressedImage"
BACK: Final = "GetBackCameraRosCompressedImage"
"""The methods that return pictures."""
SIZE: Final = 1280, 720
"""Width and height of the pictures that are expected, in pixels."""
FRAME_RATE: Final = 30.0
"""Pictures a second that are expected."""
_WAIT: Final = 2.0
"""Seconds that a picture may take."""
_WAITING: Final = 2
"""Pictures that may wait for a reader; the oldest are lost first."""


@dataclass(slots=True)
class CameraFigures:
    """Counts of one camera since the adapter began.

    Attributes:
        fetched: pictures from the robot.
        unreadable: of them, those that are no pictures.
    """

    fetched: int = 0
    unreadable: int = 0


class RobotCamera:
    """One camera; `async with` it. It is a `MediaSource`, and any number of readers share its pictures.

    A thread decodes; meanwhile the next picture is asked for. Without a reader nothing is asked for.

    Args:
        api: of the robot.
        method: that returns pictures: `FRONT` or `BACK`.
        name: in the log.
        clock: the media clock.
    """

    def __init__(self, api: KachakaApi, method: str, name: str, clock: MediaClock) -> None:
        self.figures = CameraFigures()
        self._api = api
        self._method = method
        self._clock = clock
        self._sequence = 0
        self._thread = ThreadPoolExecutor(1, name)
        self._pictures: Fanout[RawVideo] = Fanout(_Fetched(self._fetch), name=name)

    async def __aenter__(self) -> Self:
        return self

    async def __aexit__(self, *_error: object) -> None:
        self._thread.shutdown(wait=False, cancel_futures=True)

    @property
    def is_open(self) -> bool:
        """Whether pictures are fetched, because there is a reader."""
        return self._pictures.running

    @asynccontextmanager
    async def open(self) -> AsyncIterator[AsyncIterator[RawVideo]]:
        """Yield the pictures from now on; a slow reader gets the newest."""
        async with self._pictures.subscribe(_WAITING) as pictures, aclosing(_until_end(pictures)) as items:
            yield items

    async def _fetch(self) -> AsyncGenerator[RawVideo, None]:
        loop = asyncio.get_running_loop()
        poll = Poll(self._api, self._method, self._clock, _WAIT)
        fetching: asyncio.Future[Any] = asyncio.ensure_future(poll.next())
        try:
            while True:
                response, moment = await fetching, self._clock.now()
                self.figures.fetched += 1
                fetching = asyncio.ensure_future(poll.next())
                pixels = await loop.run_in_executor(self._thread, _decoded, response.image.data)
                if pixels is None:
                    self.figures.unreadable += 1
                    continue
                self._sequence += 1
                height, width = pixels.shape[:2]
                yield RawVideo(pixels, "bgr24", width, height, self._sequence, moment)
        finally:
            fetching.cancel()
            await asyncio.wait((fetching,))
            if not fetching.cancelled():
                fetching.exception()


class _Fetched:
    """The pictures as they come; a `MediaSource` for one reader."""

    def __init__(self, fetch: Callable[[], AsyncGenerator[RawVideo, None]]) -> None:
        self._fetch = fetch

    @asynccontextmanager
    async def open(self) -> AsyncIterator[AsyncIterator[RawVideo]]:
        async with aclosing(self._fetch()) as pictures:
            yield pictures


def _decoded(data: bytes) -> NDArray[np.uint8] | None:
    """Return the pixels of a JPEG (BGR), of even sides as encoders want them; None where it is none."""
    try:
        pixels = decode_image(data)
    except ImageFileError:
        return None
    height, width = (side & ~1 for side in pixels.shape[:2])
    return np.ascontiguousarray(pixels[:height, :width], np.uint8) if height and width else None


async def _until_end(pictures: Subscription[RawVideo]) -> AsyncGenerator[RawVideo, None]:
    try:
        while True:
            yield await pictures.get()
    except SourceEnded as end:
        if end.__cause__ is not None:
            raise end.__cause__ from None
