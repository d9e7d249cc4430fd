"""Recording of a body's pictures and sound into a file."""

import asyncio
from collections.abc import AsyncIterator, Callable, Mapping
from contextlib import asynccontextmanager
from typing import Any, Final, TypeAlias

from openrois_signaling.messages import MediaKind
from openrois_streaming.recording.media_file import MediaFile
from openrois_streaming.source.source import RawAudio, RawVideo

from openrois.aio.tasks import TaskScope
from openrois_media.client.media import Media
from openrois_media.client.readers import Block, Frame, StreamReader
from openrois_media.client.visitors import VisitorDevice

__all__ = ["NothingCame", "Recorded", "record"]

Recorded: TypeAlias = str | VisitorDevice
"""Reference of a component, or the device of a visitor."""

_FIRST_WITHIN: Final = 15.0
"""Seconds until the first picture or sound."""


class NothingCame(RuntimeError):
    """Recording that was ended before any media came."""


async def record(
    media: Media,
    components: Mapping[MediaKind, Recorded],
    file: MediaFile,
    seconds: float | None,
    stop: asyncio.Event,
    on_begin: Callable[[], None] = lambda: None,
) -> None:
    """Write what comes into an open `file`. That of a visitor ends when it leaves, or withdraws its consent.

    Args:
        media: open media of an application.
        components: what is recorded, by what it gives.
        file: open file, for these kinds of media.
        seconds: length of the recording, from its first media on; None until it is stopped.
        stop: ends the recording when it is set, as it is where a visitor ends it.
        on_begin: called when the first media is written.

    Raises:
        NothingCame: no media came in time, or before the recording was stopped.
        RoISError, TimeoutError, ValueError: a stream cannot be connected; see `Media`.
    """
    begun = asyncio.Event()
    tasks: list[asyncio.Task[None]] = []
    if "video" in components:
        tasks.append(asyncio.create_task(_pictures(media, components["video"], file, begun, stop)))
    if "audio" in components:
        # The file begins with the first picture, if there are any.
        own = asyncio.Event() if tasks else begun
        tasks.append(asyncio.create_task(_sound(media, components["audio"], file, own, stop)))
    stopping = asyncio.create_task(_until_over(begun, seconds, stop, on_begin))
    try:
        await asyncio.wait((stopping, *tasks), return_when=asyncio.FIRST_COMPLETED)
    finally:
        for task in (stopping, *tasks):
            task.cancel()
        outcomes = await asyncio.gather(stopping, *tasks, return_exceptions=True)
    for outcome in outcomes:
        if isinstance(outcome, Exception):
            raise outcome
    if not begun.is_set():
        raise NothingCame("nothing was recorded: no media came")


async def _until_over(
    begun: asyncio.Event, seconds: float | None, stop: asyncio.Event, on_begin: Callable[[], None]
) -> None:
    stopping = asyncio.ensure_future(stop.wait())
    beginning = asyncio.ensure_future(begun.wait())
    try:
        await asyncio.wait((stopping, beginning), timeout=_FIRST_WITHIN, return_when=asyncio.FIRST_COMPLETED)
        if not begun.is_set():
            return
        on_begin()
        await asyncio.wait((stopping,), timeout=seconds)
    finally:
        stopping.cancel()
        beginning.cancel()


async def _pictures(
    media: Media, component: Recorded, file: MediaFile, begun: asyncio.Event, stop: asyncio.Event
) -> None:
    reader: StreamReader[Frame]
    async with media.frames(component, "i420") as reader, _ending_with_visitor(component, reader, stop):
        async for frame in reader:
            raw = RawVideo(frame.data, "i420", frame.width, frame.height, 0, frame.local_time)
            await asyncio.to_thread(file.add_picture, raw)
            begun.set()


async def _sound(media: Media, component: Recorded, file: MediaFile, begun: asyncio.Event, stop: asyncio.Event) -> None:
    reader: StreamReader[Block]
    async with media.blocks(component) as reader, _ending_with_visitor(component, reader, stop):
        async for block in reader:
            await asyncio.to_thread(file.add_sound, RawAudio(block.samples, block.local_time))
            begun.set()


@asynccontextmanager
async def _ending_with_visitor(
    component: Recorded, reader: StreamReader[Any], stop: asyncio.Event
) -> AsyncIterator[None]:
    """Set `stop` when the stream of a visitor is ended; what comes if it is connected again is not recorded."""
    async with TaskScope() as tasks:
        if isinstance(component, VisitorDevice):
            tasks.start(_set_after_end(reader, stop))
        yield


async def _set_after_end(reader: StreamReader[Any], stop: asyncio.Event) -> None:
    await reader.disconnected()
    stop.set()
