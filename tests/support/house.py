"""A gateway and a synthetic avatar in the process of the test, connected over real sockets."""

import asyncio
from collections.abc import AsyncIterator
from contextlib import AsyncExitStack, asynccontextmanager
from functools import partial
from unittest.mock import patch

from openrois_avatar.adapter import Avatar, run_avatar
from openrois_avatar.options.settings import AvatarSettings
from openrois_avatar.scene import synthetic_scene
from openrois_streaming.publish.rendition import RenditionFigures

from openrois.adapter.dialer import serve_parent
from openrois.gateway.server import Gateway, run_gateway
from openrois.gateway.settings import GatewaySettings
from tests.support.black_box import Application, application

_PATIENCE = 10.0


class House:
    """The running programs, and applications.

    Attributes:
        avatar: the adapter, with all that a test may want to count.
        url: where applications connect.
        grace: to be set when the grace of lost control connections is over.
    """

    def __init__(self, avatar: Avatar, gateway: Gateway, guests: AsyncExitStack) -> None:
        self.avatar = avatar
        self.url = gateway.url.replace("http", "ws", 1)
        self.grace = asyncio.Event()
        self._guests = guests
        self._changed = asyncio.Event()
        self._serving: asyncio.Task[None] | None = None
        gateway.engine.on_change(self._changed.set)
        avatar.host.sleep = self._wait_for_the_end_of_the_grace

    async def _wait_for_the_end_of_the_grace(self, _seconds: float) -> None:
        await self.grace.wait()

    async def connect(self) -> None:
        """Connect the adapter to the gateway."""
        self._changed.clear()
        self._serving = asyncio.create_task(serve_parent(self.avatar.host, f"{self.url}adapter"))
        async with asyncio.timeout(_PATIENCE):
            await self._changed.wait()

    async def disconnect(self) -> None:
        """Cut the control connection between adapter and gateway."""
        assert self._serving is not None
        self._changed.clear()
        self._serving.cancel()
        async with asyncio.timeout(_PATIENCE):
            await asyncio.wait({self._serving})
            await self._changed.wait()

    async def guest(self) -> Application:
        """One more application; it leaves when the test ends."""
        app = await self._guests.enter_async_context(application(self.url))
        await app.hello()
        return app

    def figures(self, codec: str) -> RenditionFigures:
        """What the encoder of the picture in `codec` has done."""
        return self.avatar.video.renditions(codec)[0].figures()


@asynccontextmanager
async def house() -> AsyncIterator[House]:
    """Run all of it for as long as the block does."""
    # Pictures of one size only: a busy machine would have viewers change to another.
    small = partial(synthetic_scene, width=320, height=180)
    with patch("openrois_avatar.adapter.synthetic_scene", small):
        async with _house() as opened:
            yield opened


@asynccontextmanager
async def _house() -> AsyncIterator[House]:
    async with (
        run_gateway(GatewaySettings(port=0)) as gateway,
        run_avatar(AvatarSettings(engine="synthetic", stamp=True)) as avatar,
    ):
        async with AsyncExitStack() as guests:
            built = House(avatar, gateway, guests)
            await built.connect()
            yield built
        await built.disconnect()
        built.grace.set()
