"""Signs of life to an adapter where something moves: without them it stops within half a second."""

import asyncio
from collections.abc import Awaitable, Callable
from typing import Any

from openrois.aio.tasks import TaskScope
from openrois.jsonrpc.heartbeat import ALIVE, INTERVAL, WATCH
from openrois.jsonrpc.session import NotificationHandler, RpcSession
from openrois.types.model import Model

__all__ = ["Heartbeat"]


class _Watch(Model):
    """Params of `openrois.watch`."""

    wanted: bool


class Heartbeat:
    """The gateway's end of one adapter's heartbeat.

    Args:
        session: the connection to the adapter.
        tasks: owns what beats.
        sleep: waits for some seconds.
    """

    def __init__(
        self, session: RpcSession, tasks: TaskScope, sleep: Callable[[float], Awaitable[None]] = asyncio.sleep
    ) -> None:
        self._session = session
        self._tasks = tasks
        self._sleep = sleep
        self._beating: asyncio.Task[None] | None = None

    def notifications(self) -> dict[str, NotificationHandler]:
        """Return the handlers of the adapter's notifications."""
        return {WATCH: self._watch}

    def stop(self) -> None:
        """Stop beating."""
        if self._beating is not None:
            self._beating.cancel()
            self._beating = None

    def _watch(self, params: dict[str, Any]) -> None:
        self.stop()
        if _Watch.read_newer(params).wanted:
            self._beating = self._tasks.start(self._beat())

    async def _beat(self) -> None:
        while True:
            # What waits behind many others comes too late to be a sign of life.
            self._session.notify(ALIVE, {}, dispensable=True)
            await self._sleep(INTERVAL)
