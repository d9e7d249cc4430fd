"""Gateway and avatar adapter, each by itself, in the process of the test."""

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, suppress

from openrois_avatar.adapter import Avatar, run_avatar
from openrois_avatar.options.settings import AvatarSettings

from openrois.adapter.dialer import serve_parent
from openrois.gateway.server import Gateway, run_gateway
from openrois.gateway.settings import GatewaySettings

__all__ = ["running_avatar", "running_gateway"]


@asynccontextmanager
async def running_gateway() -> AsyncIterator[Gateway]:
    """A gateway on a free port."""
    async with run_gateway(GatewaySettings(port=0)) as gateway:
        yield gateway


@asynccontextmanager
async def running_avatar(gateway: Gateway) -> AsyncIterator[Avatar]:
    """An adapter with colour bars and a tone, attached to `gateway`."""
    url = gateway.url.replace("http", "ws", 1) + "adapter"
    async with run_avatar(AvatarSettings((url,), engine="synthetic", stamp=True)) as avatar:
        serving = asyncio.create_task(serve_parent(avatar.host, url))
        try:
            yield avatar
        finally:
            serving.cancel()
            with suppress(asyncio.CancelledError):
                await serving
