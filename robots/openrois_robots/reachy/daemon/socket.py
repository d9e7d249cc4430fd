"""The WebSocket of the daemon: what it tells fifty times a second, and targets to it."""

import asyncio
import json
import logging
from collections.abc import Callable, Mapping
from contextlib import suppress
from typing import Any, Final

import aiohttp
from openrois_streaming.clock import MediaClock

from openrois.adapter import ComponentFailed
from openrois_robots.reachy.daemon.rest import DEADLINE, Daemon, DaemonSilent, DaemonUnreachable, within

__all__ = ["SILENCE", "DaemonSocket"]

_log = logging.getLogger(__name__)

SILENCE: Final = 1.0
"""Seconds without a message after which the connection is made anew: a daemon that was stopped and started again takes
messages on the old one, and never answers there."""

_PATH: Final = "/ws/sdk"
_RETRY: Final = 0.3
_SENDING: Final = 0.3
"""Seconds that a message may take to be sent."""
_LARGEST: Final = 1 << 20


class DaemonSocket:
    """The WebSocket of one daemon, made anew whenever it is lost; `run` has to run.

    Args:
        daemon: whose it is.
        clock: the media clock.
        handle: called with each message.
    """

    def __init__(self, daemon: Daemon, clock: MediaClock, handle: Callable[[Mapping[str, Any]], None]) -> None:
        self._daemon = daemon
        self._clock = clock
        self._handle = handle
        self._socket: aiohttp.ClientWebSocketResponse | None = None

    async def run(self) -> None:
        """Stay connected until cancelled."""
        while True:
            try:
                await self._converse()
            except (DaemonUnreachable, DaemonSilent) as error:
                _log.debug("no WebSocket: %s", error)
            await self._clock.sleep_until(self._clock.now() + _RETRY)

    async def send_message(self, message: Mapping[str, Any]) -> None:
        """Send a message, which the daemon does not answer.

        Raises:
            ComponentFailed: there is no connection, or it takes nothing.
        """
        socket = self._socket
        if socket is None:
            raise ComponentFailed("there is no WebSocket to the robot's daemon")
        try:
            async with asyncio.timeout(_SENDING):
                await socket.send_str(json.dumps(message))
        except (TimeoutError, OSError, aiohttp.ClientError):
            raise ComponentFailed("the robot's daemon takes no messages") from None

    async def _converse(self) -> None:
        async def connect() -> aiohttp.ClientWebSocketResponse:
            return await self._daemon.session.ws_connect(_PATH, max_msg_size=_LARGEST)

        self._socket = await within(DEADLINE, _PATH, connect)
        try:
            while (text := await self._receive(self._socket)) is not None:
                self._read(text)
        finally:
            socket, self._socket = self._socket, None
            with suppress(TimeoutError):
                async with asyncio.timeout(_SENDING):
                    await socket.close()

    async def _receive(self, socket: aiohttp.ClientWebSocketResponse) -> str | None:
        """Return the next message; None at the end."""
        with suppress(TimeoutError):
            async with asyncio.timeout(SILENCE):
                message = await socket.receive()
            if message.type is aiohttp.WSMsgType.TEXT:
                return str(message.data)
        return None

    def _read(self, text: str) -> None:
        try:
            message = json.loads(text)
            if isinstance(message, dict):
                self._handle(message)
        except (ValueError, KeyError, TypeError, IndexError) as error:
            _log.debug("a message of the daemon was not understood: %r", error)
