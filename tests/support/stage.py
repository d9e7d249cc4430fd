"""Where faults of media are tried: a gateway, an avatar behind it, viewers, and the rules checked in the end."""

import asyncio
import tempfile
from collections.abc import AsyncIterator, Callable
from contextlib import AsyncExitStack, asynccontextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import psutil
import pytest
from openrois_avatar.adapter import Avatar, serve_scene
from openrois_avatar.scene import Scene, embedded_scene, synthetic_scene
from openrois_streaming.clock import SystemClock
from openrois_streaming.network.settings import NetworkSettings
from openrois_streaming.stats import StreamStats
from openrois_streaming.testing import ImpairedPath, Impairments

from openrois.adapter.dialer import serve_parent
from openrois.aio.tasks import TaskScope
from tests.support.ground import Ground, ground
from tests.support.loopback import some_address
from tests.support.spectator import MEDIA_PATIENCE, Spectator

__all__ = ["SMALL_GAME", "Stage", "stage"]

SMALL_GAME = "tests.support.small_game"


@dataclass
class Stage:
    """What runs.

    Attributes:
        place: the gateway, and the relay through which the avatar has dialled.
        avatar: the adapter.
        scene: what it shows.
    """

    place: Ground
    avatar: Avatar
    scene: Scene
    guests: AsyncExitStack
    paths: AsyncExitStack

    async def spectator(self, *, relayed: bool = False) -> Spectator:
        """Connect one more who watches; it leaves in the end."""
        url = self.place.relay.url if relayed else self.place.gateway.url
        book = self.place.book
        guest = await self.guests.enter_async_context(book.application(Spectator, url, extended=True))
        self.guests.push_async_callback(guest.leave)
        return guest

    @asynccontextmanager
    async def passing(self) -> AsyncIterator[Spectator]:
        """Connect one who watches while the block runs."""
        async with self.place.book.application(Spectator, self.place.gateway.url, extended=True) as guest:
            try:
                yield guest
            finally:
                await guest.leave()

    @asynccontextmanager
    async def doorway(self) -> AsyncIterator[Path]:
        """Let the gateway be reached by a Unix socket, from another network too, while the block runs."""

        async def pass_on(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
            target = urlsplit(self.place.gateway.url)
            there, back = await asyncio.open_connection(target.hostname, target.port)
            await asyncio.gather(_copy(reader, back), _copy(there, writer))

        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder, "gateway")
            async with await asyncio.start_unix_server(pass_on, path):
                yield path

    def engine(self) -> psutil.Process:
        """The process of the game engine that runs now."""
        return next(each for each in psutil.Process().children(recursive=True) if each.cmdline()[-1:] == [SMALL_GAME])

    async def stream(self, stream_id: str) -> StreamStats:
        """What the adapter has measured of a stream."""
        return next(each for each in (await self.avatar.collect_figures()).streams if each.stream_id == stream_id)

    async def path(self, down: Impairments | None = None, up: Impairments | None = None) -> ImpairedPath:
        """Make a bad network, for those who watch; it is there until they have left."""
        return await self.paths.enter_async_context(ImpairedPath(down, up, seed=self.place.chance.randrange(1 << 30)))

    async def sessions(self) -> int:
        """How many applications the adapter knows that watch."""
        return (await self.avatar.collect_figures()).process.sessions

    def encoders(self) -> set[str]:
        """The media types that are encoded now."""
        made = (*self.avatar.video.made, *self.avatar.audio.made)
        return {each.mime_type for each in made if each.running}

    async def until(self, so: Callable[[], object]) -> None:
        """Wait until a condition of the adapter holds that it does not announce."""
        async with asyncio.timeout(MEDIA_PATIENCE):
            while not so():  # noqa: ASYNC110 - see above
                await asyncio.sleep(0.02)

    async def left(self) -> dict[str, int]:
        """What there is of those who watch."""
        sessions = (await self.avatar.collect_figures()).process.sessions
        encoders = self.avatar.video.running_encoders + self.avatar.audio.running_encoders
        return {name: count for name, count in (("sessions", sessions), ("encoders", encoders)) if count}


@asynccontextmanager
async def stage(
    seed: int,
    folder: Path,
    log: pytest.LogCaptureFixture,
    *,
    game: str = "",
    size: tuple[int, int] = (160, 90),
    network: NetworkSettings | None = None,
    longest: float = 0.5,
    **settings: Any,
) -> AsyncIterator[Stage]:
    """Run an avatar behind a gateway for one seed of one fault; in the end the rules are checked.

    Args:
        seed: of all chance.
        folder: for the audit trail.
        log: of the test.
        game: the module of the game engine, a process; without one there are colour bars and a tone.
        size: of the colour bars.
        network: what of the network media uses.
        longest: see `ground`; those who watch, and decode, are in this loop too.
        settings: of the gateway, and of `ground`.
    """
    clock = SystemClock()
    with some_address(), pytest.MonkeyPatch.context() as patch:
        patch.setenv("SMALL_GAME_SEED", str(seed))
        async with ground(seed, folder, log, longest=longest, **settings) as place, AsyncExitStack() as stack:
            scene = synthetic_scene(clock, *size, 20.0)
            if game:
                scene = await stack.enter_async_context(embedded_scene("avatar", game, clock))
            avatar = await stack.enter_async_context(serve_scene("avatar", scene, clock, network))
            dialling = await stack.enter_async_context(TaskScope())
            dialling.start(serve_parent(avatar.host, place.adapter_url, sleep=_briefly))
            await place.attached("avatar")
            paths = await stack.enter_async_context(AsyncExitStack())
            async with AsyncExitStack() as guests:
                stands = Stage(place, avatar, scene, guests, paths)
                try:
                    yield stands
                except Exception as failure:
                    seen = await avatar.collect_figures()
                    failure.add_note("\n".join(map(str, (*seen.streams, *seen.renditions, *seen.sources))))
                    raise
            async with asyncio.timeout(MEDIA_PATIENCE):
                while await stands.left():  # noqa: ASYNC110 - they end by themselves
                    await asyncio.sleep(0.01)


async def _copy(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
    """Pass on what comes, and its end."""
    with suppress(OSError):
        while data := await reader.read(1 << 16):
            writer.write(data)
            await writer.drain()
    writer.close()


async def _briefly(_seconds: float) -> None:
    await asyncio.sleep(0.002)
