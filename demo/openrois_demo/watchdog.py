"""The watchdog of a demo: restarts a gateway that does not answer, and an adapter that is not connected to it."""

import asyncio
import logging
from collections.abc import Callable, Iterable, Mapping
from contextlib import AbstractAsyncContextManager
from typing import Final, Protocol

from websockets.exceptions import InvalidHandshake

from openrois.jsonrpc.session import RpcError, RpcSession, SessionClosed
from openrois.transport.stream import MessageStream
from openrois.transport.websocket import dial
from openrois.types.profiles import HRIEngineProfile
from openrois_demo.waiting import Sleep, happens

__all__ = ["Restartable", "Watchdog"]

_log = logging.getLogger(__name__)

PATIENCE: Final = 8.0
"""Seconds for which a running program may be missing: a slow one comes back by itself within them."""

START: Final = 60.0
"""Seconds that a restarted program has to come back."""

_PAUSE: Final = 0.5


class Restartable(Protocol):
    """A program that is restarted when it ends.

    Attributes:
        name: of the program.
        runs: number of starts.
    """

    name: str
    runs: int

    def kill(self) -> None:
        """Kill the process."""
        ...


class _Presence:
    """Whether a program is there, is missing, or its presence is unknown, as events to wait for."""

    def __init__(self) -> None:
        self.there = asyncio.Event()
        self.missing = asyncio.Event()
        self.excused = asyncio.Event()
        """Set unless it is missing."""

    def note(self, there: bool | None) -> None:
        holds = {self.there: there is True, self.missing: there is False, self.excused: there is not False}
        for event, now in holds.items():
            if now:
                event.set()
            else:
                event.clear()


class Watchdog:
    """Checks, as an application, whether a gateway answers and has all engines behind it.

    Args:
        url: `ws://host:port/` of the gateway.
        engine_ids: of the adapters that have to be there.
        connect: opens a connection to an address.
        sleep: waits for some seconds; all waits use it.
    """

    def __init__(
        self,
        url: str,
        engine_ids: Iterable[str],
        *,
        connect: Callable[[str], AbstractAsyncContextManager[MessageStream]] = dial,
        sleep: Sleep = asyncio.sleep,
    ) -> None:
        self._url = url
        self._connect = connect
        self._sleep = sleep
        self._gateway = _Presence()
        self._adapters = {engine_id: _Presence() for engine_id in engine_ids}

    async def until_there(self) -> None:
        """Wait until all engines are behind the gateway: before that its page lacks a body."""
        for presence in self._adapters.values():
            await presence.there.wait()

    async def watch(self, gateway: Restartable, adapters: Mapping[str, Restartable]) -> None:
        """Check until cancelled, and kill a program that is missing for too long.

        Args:
            gateway: the program of the gateway.
            adapters: those of the adapters, by their engine ids.
        """
        async with asyncio.TaskGroup() as tasks:
            tasks.create_task(self._check_components())
            tasks.create_task(self._end_when_missing(self._gateway, gateway))
            for engine_id, adapter in adapters.items():
                tasks.create_task(self._end_when_missing(self._adapters[engine_id], adapter))

    async def _check_components(self) -> None:
        while True:
            try:
                async with self._connect(self._url) as stream:
                    await self._look_over(stream)
            except (OSError, ValueError, TimeoutError, InvalidHandshake, SessionClosed, RpcError) as error:
                _log.debug("the gateway is not there: %s", error)
            self._gateway.note(there=False)
            # Without the gateway the presence of an adapter is unknown.
            for presence in self._adapters.values():
                presence.note(there=None)
            await self._sleep(_PAUSE)

    async def _look_over(self, stream: MessageStream) -> None:
        changed = asyncio.Event()
        session = RpcSession(stream, notifications={"rois.system.profile_changed": lambda _params: changed.set()})
        running = asyncio.ensure_future(session.run())
        running.add_done_callback(lambda _ended: changed.set())
        try:
            while not running.done():
                changed.clear()
                profile = (await session.call("rois.system.get_profile", {}))["profile"]
                self._gateway.note(there=True)
                there = set(HRIEngineProfile.model_validate(profile).engine_ids())
                for engine_id, presence in self._adapters.items():
                    presence.note(there=engine_id in there)
                await changed.wait()
        finally:
            running.cancel()
            await asyncio.wait({running})

    async def _end_when_missing(self, presence: _Presence, program: Restartable) -> None:
        while True:
            await presence.missing.wait()
            runs = program.runs
            if await happens(presence.excused, PATIENCE, self._sleep):
                continue
            if program.runs == runs:
                _log.warning("%s runs but does not answer: it is killed, and started again", program.name)
                program.kill()
            await happens(presence.there, START, self._sleep)
