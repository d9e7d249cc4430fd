"""The adapter's side of the connection to its parent: dial one of its gateways, serve it, and dial again for ever."""

import asyncio
import logging
import random
import ssl
import time
from collections.abc import Awaitable, Callable
from typing import Final

from websockets.exceptions import InvalidHandshake, InvalidMessage, InvalidStatus

from openrois.adapter.rotation import Rotation
from openrois.remote.serve import serve_engine
from openrois.session.session import EngineHost
from openrois.transport.backoff import asked_to_wait
from openrois.transport.credentials import CA_FILE_VARIABLE, NO_CREDENTIALS, TOKEN_FILE_VARIABLE, Credentials
from openrois.transport.stream import POLICY_VIOLATION
from openrois.transport.unreachable import unreachable
from openrois.transport.websocket import dial

__all__ = ["serve_parent"]

_log = logging.getLogger(__name__)

_NOT_NOW: Final = range(500, 600)
"""Status codes of a gateway that is about to end or is full, and of a proxy before one that is not there yet."""

_DOUBT: Final = 3.0
"""Seconds of silence after which a gateway may have given the adapter up: it pings every 1.5 s and waits for 3 s."""


async def serve_parent(
    host: EngineHost,
    *urls: str,
    credentials: Credentials = NO_CREDENTIALS,
    sleep: Callable[[float], Awaitable[None]] = asyncio.sleep,
    clock: Callable[[], float] = time.monotonic,
    chance: Callable[[], float] = random.random,
    attached: Callable[[bool], None] = lambda _is_attached: None,
) -> None:
    """Serve an engine to one gateway at a time until cancelled; where a connection is lost another one is made.

    Args:
        host: the engine.
        urls: `ws://host:port/adapter` of each gateway that it may serve; which is dialled when says `Rotation`.
        credentials: what is shown to the gateway; a token is read at every attempt.
        sleep: waits for some seconds between attempts.
        clock: monotonic seconds, to tell a connection that lasted from one that did not.
        chance: a number from 0 up to 1.
        attached: called with True when the gateway has attached the engine, with False when that connection ends.

    Raises:
        websockets.exceptions.InvalidURI: one of `urls` that is dialled is no WebSocket address.
    """
    rotation = Rotation(urls, chance)
    url, _ = rotation.next(clock())
    attempts = 0
    while True:
        lasted, asked, is_refused = 0.0, 0.0, False
        attempts += 1
        # The first attempts are shown soon, and later ones rarely: they must not fill a disk.
        news = logging.INFO if attempts.bit_count() == 1 else logging.DEBUG
        try:
            async with dial(url, credentials=credentials, doubt_after=_DOUBT) as stream:
                _log.info("connected to %s", url)
                connected, attempts, news = clock(), 0, logging.INFO
                closed = await serve_engine(host, stream, credentials, url=url, attached=attached)
                lasted, asked = clock() - connected, asked_to_wait(closed.reason)
                if closed.code == POLICY_VIOLATION:
                    _log.warning("the gateway refuses this adapter: %s", closed.reason)
                    is_refused = True
                else:
                    _log.info("the gateway is gone: %s", closed)
        except (InvalidHandshake, ValueError, OSError) as error:
            # A gateway may come later; what an operator has to correct is a warning.
            may_come = _may_come(error)
            said = unreachable(url, error, remedies=(TOKEN_FILE_VARIABLE, CA_FILE_VARIABLE))
            _log.log(news if may_come else logging.WARNING, "%s", said)
            is_refused = not may_come
        rotation.failed(clock(), lasted=lasted, asked=asked, is_refused=is_refused)
        former, (url, delay) = url, rotation.next(clock())
        if url == former or delay > 0:
            _log.log(news, "trying again in %.1f s", delay)
            await sleep(delay)
        else:
            _log.log(news, "trying %s", url)


def _may_come(error: Exception) -> bool:
    """Tell whether there is no gateway, or one that starts or ends, as opposed to one that refuses the adapter."""
    if isinstance(error, InvalidStatus):
        return error.response.status_code in _NOT_NOW
    if isinstance(error, InvalidMessage):
        return isinstance(error.__cause__, EOFError)
    return isinstance(error, OSError) and not isinstance(error, ssl.SSLError)
