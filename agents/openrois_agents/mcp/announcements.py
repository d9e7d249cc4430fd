"""Tells a host what has changed: the event log, and tools and profiles where bodies came or went."""

import asyncio
from collections.abc import Awaitable
from contextlib import suppress
from typing import Any, Final

from mcp.server.context import ServerRequestContext
from mcp.server.session import ServerSession
from mcp.server.subscriptions import (
    InMemorySubscriptionBus,
    ListenHandler,
    ResourcesListChanged,
    ResourceUpdated,
    ToolsListChanged,
)
from mcp.shared.exceptions import MCPError
from mcp_types import SubscriptionsListenRequestParams, SubscriptionsListenResult

from openrois_agents.tools.documents import BODIES, EVENTS
from openrois_agents.tools.session import Session

__all__ = ["Announcements"]

MAX_LISTENERS: Final = 4
"""Connections of one caller that are told of changes; the newest ones."""

_PAUSE: Final = 0.2
"""Seconds between two announcements of the same."""

_PATIENCE: Final = 1.0
"""Seconds for which a host is waited for."""


class _Connections:
    """The newest connections of the older generation, each once."""

    def __init__(self) -> None:
        self._by_greeting: dict[int, ServerSession] = {}

    def add(self, connection: ServerSession) -> None:
        """Add a connection; the library has another object for it with each request."""
        greeting = id(connection.client_params)
        self._by_greeting.pop(greeting, None)
        self._by_greeting[greeting] = connection
        if len(self._by_greeting) > MAX_LISTENERS:
            del self._by_greeting[next(iter(self._by_greeting))]

    def newest(self) -> tuple[ServerSession, ...]:
        """Return them."""
        return tuple(self._by_greeting.values())


class Announcements:
    """Tells the host of one caller of changes, in both generations of the protocol.

    Args:
        session: of the caller.
    """

    def __init__(self, session: Session) -> None:
        self._bus = InMemorySubscriptionBus()
        self._listen = ListenHandler(self._bus, max_subscriptions=MAX_LISTENERS)
        self._changed: set[str] = set()
        self._news = asyncio.Event()
        self._connections = _Connections()
        self._subscribed: dict[str, _Connections] = {}
        session.log.added.add(lambda _event: self._note(EVENTS))
        session.profile_changed.add(lambda: self._note(BODIES))
        session.start(self._announce())

    async def listen(
        self, context: ServerRequestContext[Any, Any], params: SubscriptionsListenRequestParams
    ) -> SubscriptionsListenResult:
        """Serve one stream of changes to a host of the newer generation."""
        return await self._listen(context, params)

    def add_connection(self, connection: ServerSession) -> None:
        """Tell a host of the older generation when the lists have changed."""
        self._connections.add(connection)

    def subscribe(self, connection: ServerSession, address: str) -> None:
        """Tell a host of the older generation when a document has changed."""
        if address in (BODIES, EVENTS):
            self._subscribed.setdefault(address, _Connections()).add(connection)

    def unsubscribe(self, address: str) -> None:
        """Tell hosts of the older generation of a document no more."""
        self._subscribed.pop(address, None)

    def _note(self, address: str) -> None:
        self._changed.add(address)
        self._news.set()

    async def _announce(self) -> None:
        while True:
            await self._news.wait()
            self._news.clear()
            changed, self._changed = self._changed, set()
            for address in sorted(changed):
                await self._bus.publish(ResourceUpdated(uri=address))
                for connection in self._subscribed.get(address, _Connections()).newest():
                    await _told(connection.send_resource_updated(address))
            if BODIES in changed:
                await self._bus.publish(ToolsListChanged())
                await self._bus.publish(ResourcesListChanged())
                for connection in self._connections.newest():
                    await _told(connection.send_tool_list_changed())
                    await _told(connection.send_resource_list_changed())
            await asyncio.sleep(_PAUSE)


async def _told(telling: Awaitable[None]) -> None:
    """Wait until a host was told; one that does not read, or has gone, holds nothing up."""
    with suppress(TimeoutError, MCPError):
        async with asyncio.timeout(_PATIENCE):
            await telling
