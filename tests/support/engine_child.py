"""A real game engine in a child process, on a real engine link, as the adapter sees it."""

import asyncio
import os
import sys
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from openrois_avatar.link.address import ADDRESS_VARIABLE, SECRET_VARIABLE
from openrois_avatar.link.connection import EngineConnection
from openrois_avatar.link.messages import Completed, Event
from openrois_avatar.link.server import LinkServer
from openrois_streaming.source.source import RawAudio, RawVideo

PATIENCE = 60.0
"""Seconds within which anything is expected, on a machine that is busy."""


@dataclass(slots=True)
class Child:
    """An engine that runs: `pictures` are those it sends from now on."""

    process: asyncio.subprocess.Process
    connection: EngineConnection
    pictures: AsyncIterator[RawVideo]
    sound: list[RawAudio]
    events: list[Event]

    async def take(self, count: int) -> list[RawVideo]:
        """The next pictures."""
        async with asyncio.timeout(PATIENCE):
            return [await anext(self.pictures) for _ in range(count)]

    async def until(self, seen: Callable[[RawVideo], bool]) -> RawVideo:
        """Return the first picture that meets a condition."""
        async with asyncio.timeout(PATIENCE):
            while not seen(picture := await anext(self.pictures)):
                pass
            return picture

    async def completed(self, id: str) -> Completed:
        """Return how the reaction with this id ended."""
        async with asyncio.timeout(PATIENCE):
            while True:
                for event in self.events:
                    if isinstance(event, Completed) and event.id == id:
                        return event
                await anext(self.pictures)


def luma(picture: RawVideo) -> npt.NDArray[np.float32]:
    """The brightness of a picture, (height, width)."""
    return np.asarray(picture.data[: picture.height], np.float32)


def difference(first: RawVideo, second: RawVideo, rows: slice = slice(None), columns: slice = slice(None)) -> float:
    """The mean difference in brightness of a region, 0..219."""
    return float(np.abs(luma(first)[rows, columns] - luma(second)[rows, columns]).mean())


async def start(engine: str, address: str, secret: str) -> asyncio.subprocess.Process:
    """Start an engine for the adapter at an address."""
    environment = {**os.environ, ADDRESS_VARIABLE: address, SECRET_VARIABLE: secret}
    module = f"openrois_avatar.engines.{engine}"
    return await asyncio.create_subprocess_exec(sys.executable, "-m", module, "--size", "640x360", env=environment)


@asynccontextmanager
async def running(engine: str) -> AsyncIterator[Child]:
    """An engine for as long as the context lasts."""
    sound: list[RawAudio] = []
    events: list[Event] = []
    async with LinkServer.listen(on_audio=sound.append, on_event=events.append) as server:
        process = await start(engine, server.address, server.secret)
        try:
            connection = await server.accept(PATIENCE)
            async with server.video.open() as pictures:
                yield Child(process, connection, pictures, sound, events)
        finally:
            if process.returncode is None:
                process.kill()
            await process.wait()
