"""External game engines: awaited at an address, and disconnected when they hang."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable
from contextlib import AsyncExitStack
from types import TracebackType
from typing import Final, Self

from openrois_streaming.clock import MediaClock, SystemClock
from openrois_streaming.source.source import RawAudio

from openrois.aio.tasks import TaskScope
from openrois_avatar.link.linked_engine import LinkedEngine
from openrois_avatar.link.messages import Event, Hello
from openrois_avatar.link.receivers import notify

FIRST_PICTURE: Final = 20.0
"""Seconds that an engine has from its greeting to its first picture."""

_log = logging.getLogger(__name__)


class ExternalEngine(LinkedEngine):
    """The engines that connect to an address, one after another, for as long as the context lasts.

    Entering does not wait for one. `on_back` reports each connection, `on_lost` the reason of each end: an engine may
    come back at any moment, and another one may take its place.

    Args:
        address: where it listens, see `LinkServer.listen`.
        secret: that an engine has to send; empty: any will do.
        on_audio: gets its blocks of sound.
        on_event: gets its events.
        on_lost: called with the reason when the engine is disconnected.
        on_back: called with its HELLO when it is connected.
        clock: the media clock; the machine's if not given.

    Raises:
        LinkError: on entering: the address is malformed, not of this machine alone, or cannot be listened on.
    """

    def __init__(
        self,
        address: str,
        secret: str = "",
        *,
        on_audio: Callable[[RawAudio], None] | None = None,
        on_event: Callable[[Event], None] | None = None,
        on_lost: Callable[[str], None] | None = None,
        on_back: Callable[[Hello], None] | None = None,
        clock: MediaClock | None = None,
    ) -> None:
        super().__init__(
            address,
            secret,
            on_audio=on_audio,
            on_event=on_event,
            on_hello=on_back,
            on_gone=self._went,
            clock=clock or SystemClock(),
        )
        self._on_lost = on_lost

    async def __aenter__(self) -> Self:
        async with AsyncExitStack() as stack:
            self._server = await stack.enter_async_context(self._listening)
            tasks = await stack.enter_async_context(TaskScope())
            tasks.start(self._disconnect_hung_engines())
            _log.info("no game engine is connected; one is awaited at %s", self._server.address)
            self._stack = stack.pop_all()
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._on_lost = None
        await self._stack.aclose()

    @property
    def address(self) -> str:
        """The address at which engines are awaited, with the port that the system chose."""
        return self._server.address

    def _went(self, reason: str) -> None:
        notify(self._on_lost, reason)

    async def _disconnect_hung_engines(self) -> None:
        while True:
            connection = await self._server.accept()
            hanging = asyncio.create_task(self._stall(FIRST_PICTURE), name="watch the game engine")
            ending = asyncio.create_task(connection.closed(), name="the game engine's connection")
            try:
                await asyncio.wait({hanging, ending}, return_when=asyncio.FIRST_COMPLETED)
                if not ending.done():
                    connection.close("no picture has come for a while; send pictures, `pause` or `idle`")
                await ending
            finally:
                hanging.cancel()
                ending.cancel()
