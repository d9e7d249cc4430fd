"""A gateway with an avatar in which a voice agent is, and which can be lost; with tokens where they are wanted."""

import time
from collections.abc import AsyncIterator
from contextlib import AsyncExitStack, asynccontextmanager
from pathlib import Path

from openrois.gateway.server import run_gateway
from openrois.gateway.settings import GatewaySettings
from openrois.transport.credentials import NO_CREDENTIALS, Credentials
from tests.support.deployment import until
from tests.support.operated import noting_avatar
from tests.support.tokens import issue, key_file

__all__ = ["House", "agent_and_visitor", "house", "token"]


def token(subject: str, **claims: object) -> str:
    """Return a token for the avatar."""
    return issue(time.time(), sub=subject, **{"scope": ["avatar/*"], **claims})


def agent_and_visitor() -> dict[str, str]:
    """Return the tokens of an agent that speaks through the avatar, and of the visitor that it hears."""
    return {
        "agent": token("mind", rank="agent", roles=["operator", "listener"]),
        "visitor": token("vito", rank="person", roles=["visitor"]),
    }


class House:
    """A gateway with an avatar that can be lost.

    Attributes:
        url: where applications connect.
    """

    def __init__(self, url: str, avatar: AsyncExitStack) -> None:
        self.url = url
        self._avatar = avatar

    async def lose_avatar(self) -> None:
        """End the avatar's adapter."""
        await self._avatar.aclose()


@asynccontextmanager
async def house(folder: Path, *, with_tokens: bool = False) -> AsyncIterator[House]:
    """Run a gateway and the avatar `avatar` behind it."""
    keys = (key_file(folder),) if with_tokens else ()
    credentials = NO_CREDENTIALS
    if with_tokens:
        credentials = Credentials(token("avatar", roles=["adapter"]))
    async with run_gateway(GatewaySettings(port=0, auth_keys=keys)) as gateway, AsyncExitStack() as avatar:
        url = gateway.url.replace("http", "ws", 1)
        await avatar.enter_async_context(noting_avatar(folder, f"{url}adapter", credentials))
        await until(gateway.engine, lambda ids: "avatar" in ids)
        yield House(url, avatar)
