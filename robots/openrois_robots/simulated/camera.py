"""The robot's camera as a source of pictures: drawn in a thread of its own, and only while the source is open."""

import asyncio
from collections import deque
from collections.abc import AsyncGenerator, AsyncIterator, Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import aclosing, asynccontextmanager
from typing import Final, Self

import numpy as np
from numpy.typing import NDArray
from openrois_streaming.clock import MediaClock
from openrois_streaming.source.fanout import Fanout, SourceEnded, Subscription
from openrois_streaming.source.source import RawVideo

from openrois_robots.simulated.drawing.renderer import Renderer
from openrois_robots.simulated.drawing.view import View
from openrois_robots.simulated.world.plan import Plan

__all__ = ["FRAME_RATE", "SIZE", "RobotCamera"]

FRAME_RATE: Final = 30.0
"""Pictures a second."""
SIZE: Final = 640, 360
"""Width and height of the pictures, in pixels."""
_VIEWS: Final = round(12 * FRAME_RATE)
"""Views that are remembered: an analysis of a picture takes 10 s at most."""
_CLOSE_TIMEOUT: Final = 5.0
"""Seconds that the renderer may take to close."""


class RobotCamera:
    """The camera; `async with` it. It is a `MediaSource`, and any number of readers share its pictures.

    A thread draws, because a picture takes some milliseconds; Panda3D lets other threads run meanwhile. Without a
    reader nothing is drawn, and the rooms are built for the first one.

    Args:
        plan: of the rooms.
        look: lets the simulation go on to the present, and returns what the camera sees then.
        clock: the media clock.
    """

    def __init__(self, plan: Plan, look: Callable[[], View], clock: MediaClock) -> None:
        self._plan = plan
        self._look = look
        self._clock = clock
        self._renderer: Renderer | None = None
        self._sequence = 0
        self._views: deque[tuple[float, View]] = deque(maxlen=_VIEWS)
        self._thread = ThreadPoolExecutor(1, "camera")
        self._pictures: Fanout[RawVideo] = Fanout(_Drawn(self._draw), name="camera")

    async def __aenter__(self) -> Self:
        return self

    async def __aexit__(self, *_error: object) -> None:
        # The last reader has left by now; a picture that is still drawn comes first.
        closing = asyncio.get_running_loop().run_in_executor(self._thread, self._close)
        await asyncio.wait({closing}, timeout=_CLOSE_TIMEOUT)
        self._thread.shutdown(wait=False, cancel_futures=True)

    @property
    def is_open(self) -> bool:
        """Whether it draws, because there is a reader."""
        return self._pictures.running

    @property
    def drawn(self) -> int:
        """The number of pictures that were drawn."""
        return self._sequence

    def view_at(self, moment: float) -> View | None:
        """Return what a picture shows, by its capture time; None where that is long ago."""
        return next((view for at, view in reversed(self._views) if at == moment), None)

    @asynccontextmanager
    async def open(self) -> AsyncIterator[AsyncIterator[RawVideo]]:
        """Yield the pictures from now on; a slow reader gets the newest."""
        async with self._pictures.subscribe(1) as pictures, aclosing(_until_end(pictures)) as items:
            yield items

    async def _draw(self) -> AsyncGenerator[RawVideo, None]:
        loop = asyncio.get_running_loop()
        width, height = SIZE
        due = self._clock.now()
        while True:
            await self._clock.sleep_until(due)
            view, moment = self._look(), self._clock.now()
            self._views.append((moment, view))
            pixels = await loop.run_in_executor(self._thread, self._picture, view)
            self._sequence += 1
            yield RawVideo(pixels, "bgra", width, height, self._sequence, moment)
            due = max(due + 1 / FRAME_RATE, self._clock.now() - 1 / FRAME_RATE)

    def _picture(self, view: View) -> NDArray[np.uint8]:
        if self._renderer is None:
            self._renderer = Renderer(self._plan, *SIZE)
        return self._renderer.draw(view)

    def _close(self) -> None:
        if self._renderer is not None:
            self._renderer.close()


class _Drawn:
    """The pictures as they are drawn; a `MediaSource` for one reader."""

    def __init__(self, draw: Callable[[], AsyncGenerator[RawVideo, None]]) -> None:
        self._draw = draw

    @asynccontextmanager
    async def open(self) -> AsyncIterator[AsyncIterator[RawVideo]]:
        async with aclosing(self._draw()) as pictures:
            yield pictures


async def _until_end(pictures: Subscription[RawVideo]) -> AsyncGenerator[RawVideo, None]:
    try:
        while True:
            yield await pictures.get()
    except SourceEnded as end:
        if end.__cause__ is not None:
            raise end.__cause__ from None
