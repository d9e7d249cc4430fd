"""An avatar that is operated: a gateway, an adapter in this process, and a game engine that takes notes."""

import asyncio
import threading
import time
from collections.abc import AsyncIterator, Callable, Sequence
from contextlib import asynccontextmanager, suppress
from dataclasses import replace
from pathlib import Path
from typing import Self

from openrois_avatar.adapter import serve_scene
from openrois_avatar.link.client import LinkClient
from openrois_avatar.link.messages import Command, Input, Place, VideoShape
from openrois_avatar.link.protocol import PixelFormat
from openrois_avatar.scene import external_scene
from openrois_streaming.clock import SystemClock

from openrois.adapter import Component
from openrois.adapter.dialer import serve_parent
from openrois.gateway.server import Gateway
from openrois.transport.credentials import NO_CREDENTIALS, Credentials
from tests.support.avatar_link import HELLO
from tests.support.deployment import gateway, until

SHAPE = VideoShape(64, 36, 30, "i420")
PICTURE = bytes([128]) * (64 * 36 * 3 // 2)


class NotingEngine:
    """A game engine in a thread: a grey picture 30 times a second, and a note of each command with its time."""

    def __init__(self, address: str) -> None:
        self.heard: list[tuple[float, Command]] = []
        self._ends = False
        self._loop, self._news = asyncio.get_running_loop(), asyncio.Event()
        self._thread = threading.Thread(target=self._run, args=(address,))

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._ends = True
        self._thread.join(10)

    def _run(self, address: str) -> None:
        hello = replace(HELLO, video=SHAPE, audio_channels=None, hears=False, walks=True, input=True)
        with LinkClient.connect(address, hello) as link:
            link.send_event(Place(0.0, 0.0, 0.0))
            due = 0.0
            while link.connected and not self._ends:
                if commands := link.poll_commands(0.005):
                    self.heard += [(time.monotonic(), each) for each in commands]
                    self._loop.call_soon_threadsafe(self._news.set)
                if time.monotonic() >= due:
                    due = time.monotonic() + 1 / 30
                    link.send_video(PICTURE, 64, 36, 64, PixelFormat.I420, time.monotonic_ns())

    def times(self, kind: type[Command]) -> list[float]:
        return [at for at, command in self.heard if isinstance(command, kind)]

    @property
    def inputs(self) -> list[str]:
        return [str(command.message["event"]) for _, command in self.heard if isinstance(command, Input)]

    async def until(self, so: Callable[[], object]) -> None:
        async with asyncio.timeout(60):
            while not so():
                self._news.clear()
                await self._news.wait()


@asynccontextmanager
async def operated_avatar(folder: Path) -> AsyncIterator[tuple[Gateway, NotingEngine]]:
    """Run a gateway and the avatar `avatar` behind it; its engine link is in `folder`."""
    async with (
        gateway() as running,
        noting_avatar(folder, running.url.replace("http", "ws") + "adapter") as engine,
    ):
        await until(running.engine, lambda ids: "avatar" in ids)
        yield running, engine


@asynccontextmanager
async def noting_avatar(
    folder: Path, url: str, credentials: Credentials = NO_CREDENTIALS, added: Sequence[type[Component]] = ()
) -> AsyncIterator[NotingEngine]:
    """Run the avatar `avatar` alone, which dials a gateway, with components added; its engine link is in `folder`."""
    clock, address = SystemClock(), f"unix:{folder}/engine"
    async with (
        external_scene("avatar", address, "secret", clock) as scene,
        serve_scene("avatar", scene, clock, added=added) as avatar,
    ):
        dialling = asyncio.ensure_future(serve_parent(avatar.host, url, credentials=credentials))
        with NotingEngine(address) as engine:
            try:
                yield engine
            finally:
                dialling.cancel()
                with suppress(asyncio.CancelledError):
                    await dialling
