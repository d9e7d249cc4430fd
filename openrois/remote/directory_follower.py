"""Follows the directory of another gateway over a connection, engine by engine."""

import asyncio
from collections.abc import Awaitable, Callable, Mapping
from typing import Final

from openrois.errors import ComponentFailed, EngineUnreachable
from openrois.jsonrpc.session import NotificationHandler
from openrois.remote.followed_engines import FollowedEngine
from openrois.remote.greeting import Greeting
from openrois.remote.remote_directory import RemoteDirectory
from openrois.remote.rpc_call import RpcCalls
from openrois.types.directory import DIRECTORY
from openrois.types.streams import EXTENSION_VERSION

__all__ = ["DirectoryFollower", "FollowedEngine"]

PAUSE: Final = 0.1
"""Seconds between two reads: what changes meanwhile shares the next one."""


class DirectoryFollower:
    """Follows one gateway; its own components, which no engine below it owns, are left out.

    Args:
        calls: asks the gateway. The session's `notifications` have to hold this follower's `notifications()`.
        changed: called with the engines right below the gateway's main one that are new or others now, and with None
            for those that are gone; must not block. One that left and came back as it was counts as another one,
            because subscriptions to it are lost; so do all when the gateway does not name what has changed. The first
            call has all engines but those that change at that moment.
        sleep: waits for some seconds, between two reads.
    """

    def __init__(
        self,
        calls: RpcCalls,
        changed: Callable[[Mapping[str, FollowedEngine | None]], None],
        sleep: Callable[[float], Awaitable[None]] = asyncio.sleep,
    ) -> None:
        self._calls = calls
        self._changed = changed
        self._sleep = sleep
        self._due = asyncio.Event()
        self._lost: str | None = None
        self._directory = RemoteDirectory(calls, lambda _engine_ids: self._due.set())

    def notifications(self) -> dict[str, NotificationHandler]:
        """Return the handlers of the notifications that come over the connection."""
        return self._directory.notifications()

    def lost(self, reason: str) -> None:
        """Note that the connection has ended: `run` ends."""
        self._calls.lost = True
        self._lost = reason
        self._due.set()

    async def run(self) -> None:
        """Follow the directory until the connection ends or the gateway cannot be followed, which is raised.

        Raises:
            BadParameter: the directory is no tree, or too large.
            ComponentFailed: the gateway has none, or contradicts itself.
            EngineUnreachable: the connection has ended.
            RoISError: the gateway did not answer as it should.
        """
        params = {"version": EXTENSION_VERSION, "extensions": [DIRECTORY]}
        greeting = await self._calls.ask("openrois.hello", params, Greeting)
        if DIRECTORY not in greeting.extensions:
            raise ComponentFailed(f"the gateway does not offer {DIRECTORY}: it is too old to be followed")
        is_first = True
        while self._lost is None:
            self._due.clear()
            changes = await self._directory.read()
            if changes or (is_first and self._directory.is_listed):
                is_first = False
                self._changed(changes)
            await self._sleep(PAUSE)
            if self._directory.is_settled:
                await self._due.wait()
        raise EngineUnreachable(f"the connection to the gateway has ended: {self._lost}")
