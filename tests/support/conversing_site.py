"""A gateway with bodies on real connections, for conversations."""

import asyncio
import time
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

from openrois.adapter import Component
from openrois.adapter.running import serve
from openrois.client import Client
from openrois.gateway.server import run_gateway
from openrois.gateway.settings import GatewaySettings
from tests.support.actors import Actor
from tests.support.conversing import PATIENCE
from tests.support.tokens import issue, key_file

__all__ = ["ConversingSite", "conversing_site"]


class ConversingSite:
    """A gateway that asks for tokens, and where it is.

    Attributes:
        url: where applications connect.
    """

    def __init__(self, url: str, folder: Path) -> None:
        self.url = url
        self._folder = folder

    def client(self, subject: str = "mind", rank: str = "agent") -> Client:
        """Return a client with a token."""
        return Client(self.url, token=issue(time.time(), sub=subject, scope=["*/*"], rank=rank))

    @asynccontextmanager
    async def body(self, engine_id: str, actor: Actor, *more: Component) -> AsyncIterator[None]:
        """Put a body behind the gateway while the block runs, with more components where they are given."""
        file = self._folder / f"{engine_id}.token"
        file.write_text(issue(time.time(), sub=engine_id, roles=["adapter"], scope=[f"{engine_id}/*"]))
        async with serve(*actor.parts, *more, engine_id=engine_id, gateway=f"{self.url}adapter", token_file=file):
            await self.until(engine_id)
            yield

    async def until(self, engine_id: str, *, free: bool | None = None) -> None:
        """Wait until there is a body, and it is free where that is asked for."""
        async with self.client("ann", "person") as client, asyncio.timeout(PATIENCE):
            while True:
                found = {each.engine_id: each.free for each in await client.bodies()}
                if engine_id in found and free in (None, found[engine_id]):
                    return


@asynccontextmanager
async def conversing_site(folder: Path, lease_grace: float = 5.0) -> AsyncIterator[ConversingSite]:
    """Run a gateway while the block does, which keeps the leases of a lost connection for seconds of grace."""
    settings = GatewaySettings(port=0, auth_keys=(key_file(folder),), lease_grace=lease_grace)
    async with run_gateway(settings) as gateway:
        yield ConversingSite(gateway.url.replace("http", "ws", 1), folder)
