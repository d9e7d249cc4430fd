"""A caller's connection to the gateway: made when it is needed, and made anew when it is over."""

import asyncio
from collections.abc import Callable
from contextlib import AsyncExitStack
from types import TracebackType
from typing import TYPE_CHECKING, Self

from openrois.aio.listeners import Listeners
from openrois.client import Client, ConnectionState
from openrois.extras import needing_extra

if TYPE_CHECKING:
    from openrois_media import Media

__all__ = ["GatewayLink"]


class GatewayLink:
    """Connects one caller to the gateway, with the caller's own token.

    Args:
        make_client: returns a client that is not connected yet.

    Attributes:
        connected: told of each client that was connected.
    """

    def __init__(self, make_client: Callable[[], Client]) -> None:
        self._make_client = make_client
        self._turn = asyncio.Lock()
        self._client: Client | None = None
        self._media: Media | None = None
        self._stack = AsyncExitStack()
        self.connected: Listeners[Client] = Listeners()

    async def __aenter__(self) -> Self:
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Take leave of the gateway, which releases what is bound."""
        self._client = self._media = None
        await self._stack.aclose()

    @property
    def is_open(self) -> bool:
        """Whether there is a connection, or one is being made again."""
        return self._client is not None and self._client.state is not ConnectionState.CLOSED

    async def client(self) -> Client:
        """Return the connected client.

        Raises:
            ConnectionFailed: there is no gateway, or it does not let the caller in.
        """
        async with self._turn:
            if self._client is None or not self.is_open:
                self._client = self._media = None
                await self._stack.aclose()
                client = self._make_client()
                await client.connect()
                self._stack.push_async_callback(client.close)
                self._client = client
                self.connected.notify_all(client)
            return self._client

    async def media(self) -> "Media":
        """Return the media of the connected client.

        Raises:
            MissingExtra: the libraries for media are not installed.
            ConnectionFailed: there is no gateway.
        """
        with needing_extra("streaming"):
            from openrois_media import Media
        client = await self.client()
        async with self._turn:
            if self._media is None:
                self._media = await self._stack.enter_async_context(Media(client))
            return self._media
