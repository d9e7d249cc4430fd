"""Drain: a gateway that stops admits no connection, lets commands end, and tells every client when to come back."""

import asyncio
import logging
import random
import time
from collections.abc import Awaitable, Callable
from typing import Final

from openrois.commands.stop import stop_components
from openrois.jsonrpc.session import RpcSession
from openrois.session.session import RESTARTS, EngineHost

__all__ = ["RETRY_AFTER", "SERVICE_RESTART", "Drain"]

_log = logging.getLogger(__name__)

SERVICE_RESTART: Final = 1012
"""The close code of a gateway that is about to be there again (RFC 6455, IANA registry)."""

RETRY_AFTER: Final = 2
"""Seconds that a client refused meanwhile is asked to wait."""

PER_SECOND: Final = 200
"""Applications that are asked to come back within one second; adapters come before them."""

MOST: Final = 8.0
"""Seconds over which they are spread at most."""

_ADAPTERS: Final = 0.25, 0.75
_APPLICATIONS: Final = 2.0
"""Seconds: a gateway takes one to be there again, and its adapters at most another to find it."""

_ADAPTERS_OF_OTHERS: Final = 0.0, 0.5
_APPLICATIONS_OF_OTHERS: Final = 0.5
"""Seconds, where other gateways are there: their adapters have until then."""

_LOOK: Final = 0.05
_LAST_WORDS: Final = 1.0


async def _at_once() -> None:
    """Wait for nothing."""


class Drain:
    """Stops a gateway in good order.

    Args:
        host: the gateway's engine.
        patience: seconds that what runs has to end by itself.
        relayed: the number of commands of applications here that run at other gateways.
        has_others: whether other gateways are there, which take the clients of this one.
        settle: waited for before the connections are closed.
        sleep: waits for some seconds.
        clock: monotonic seconds.
        chance: a number from 0 up to 1.
    """

    def __init__(
        self,
        host: EngineHost,
        patience: float,
        *,
        relayed: Callable[[], int] = lambda: 0,
        has_others: Callable[[], bool] = lambda: False,
        settle: Callable[[], Awaitable[None]] = _at_once,
        sleep: Callable[[float], Awaitable[None]] = asyncio.sleep,
        clock: Callable[[], float] = time.monotonic,
        chance: Callable[[], float] = random.random,
    ) -> None:
        self._host = host
        self._patience = patience
        self._relayed = relayed
        self._has_others = has_others
        self._settle = settle
        self._sleep = sleep
        self._clock = clock
        self._chance = chance

    async def run(self) -> None:
        """Admit no connection, wait for what runs, hand back what still does, and close every connection.

        The components of what is handed back are stopped, and its commands end with ABORT. What still runs at other
        gateways runs on: its application finds it again at any of them.
        """
        host = self._host
        host.draining = True
        _log.info("stopping: %d commands run, and have %.0f s", host.commands.taken, self._patience)
        await self._until(lambda: not host.commands.taken and not self._relayed(), self._patience)
        if left := host.commands.taken:
            _log.warning("stopping: %d commands are handed back", left)
            busy = host.pending.components()
            for command in (command for ref in busy for command in host.pending.of(ref)):
                # Before the component says that it was stopped: why it was is worth more.
                command.abort(RESTARTS)
            await stop_components(host.engine, host.pending, host.tasks, busy, RESTARTS)
            await self._until(lambda: not host.commands.taken, _LAST_WORDS)
        await self._settle()
        adapters, least = _ADAPTERS, _APPLICATIONS
        if self._has_others():
            adapters, least = _ADAPTERS_OF_OTHERS, _APPLICATIONS_OF_OTHERS
        applications = host.connection_stats.sessions("application")
        await self._close(applications, least, min(len(applications) / PER_SECOND, MOST))
        await self._close(host.connection_stats.sessions("adapter"), *adapters)

    async def _until(self, is_idle: Callable[[], bool], patience: float) -> None:
        deadline = self._clock() + patience
        while not is_idle() and self._clock() < deadline:
            await self._sleep(_LOOK)

    async def _close(self, sessions: tuple[RpcSession, ...], least: float, spread: float) -> None:
        """Close connections, each with its own time to come back."""
        closing = (
            session.close(SERVICE_RESTART, f"retry_after={least + spread * self._chance():.2f}") for session in sessions
        )
        await asyncio.gather(*closing)
