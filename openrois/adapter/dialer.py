"""The adapter's side of the connection to its parent: dial, serve, and dial again for ever."""

import asyncio
import logging
import random
import ssl
import time
from collections.abc import Awaitable, Callable
from typing import Final

from websockets.exceptions import InvalidHandshake, InvalidMessage, InvalidStatus

from openrois.remote.serve import serve_engine
from openrois.session.session import EngineHost
from openrois.transport.backoff import Backoff, asked_to_wait
from openrois.transport.credentials import CA_FILE_VARIABLE, NO_CREDENTIALS, TOKEN_FILE_VARIABLE, Credentials
from openrois.transport.stream import POLICY_VIOLATION
from openrois.transport.unreachable import unreachable
from openrois.transport.websocket import dial

__all__ = ["LONGEST_WAIT", "serve_parent"]

_log = logging.getLogger(__name__)

LONGEST_WAIT: Final = 1.0
"""Seconds between two attempts at most while there is no gateway: adapters are back before the applications."""

_FIRST_WAIT: Final = 0.25
_LONGEST_REFUSED: Final = 5.0
_NOT_NOW: Final = range(500, 600)
"""Status codes of a gateway that is about to end or is full, and of a proxy before one that is not there yet."""


async def serve_parent(
    host: EngineHost,
    url: str,
    *,
    credentials: Credentials = NO_CREDENTIALS,
    sleep: Callable[[float], Awaitable[None]] = asyncio.sleep,
    clock: Callable[[], float] = time.monotonic,
    chance: Callable[[], float] = random.random,
    attached: Callable[[bool], None] = lambda _is_attached: None,
) -> None:
    """Serve an engine to the gateway at `url` until cancelled; a lost connection is made again.

    Args:
        host: the engine.
        url: `ws://host:port/adapter` of the gateway.
        credentials: what is shown to the gateway; a token is read at every attempt.
        sleep: waits for some seconds between attempts: up to 0.25 s, then half as long again each time, at most
            `LONGEST_WAIT`, and by chance less, so that a fleet does not come at once; longer by what a gateway that
            restarts asks for. Where a gateway answers and refuses the adapter it is up to 1 s, later up to 5 s.
        clock: monotonic seconds, to tell a connection that lasted from one that did not.
        chance: a number from 0 up to 1.
        attached: called with True when the gateway has attached the engine, with False when that connection ends.

    Raises:
        websockets.exceptions.InvalidURI: `url` is no WebSocket address.
    """
    absent, refused = Backoff(_FIRST_WAIT, limit=LONGEST_WAIT), Backoff(limit=_LONGEST_REFUSED)
    attempts = 0
    while True:
        lasted, asked, backoff = 0.0, 0.0, absent
        attempts += 1
        # The first attempts are shown soon, and later ones rarely: they must not fill a disk.
        news = logging.INFO if attempts.bit_count() == 1 else logging.DEBUG
        try:
            async with dial(url, credentials=credentials) as stream:
                _log.info("connected to %s", url)
                connected, attempts, news = clock(), 0, logging.INFO
                closed = await serve_engine(host, stream, credentials, url=url, attached=attached)
                lasted, asked = clock() - connected, asked_to_wait(closed.reason)
                if closed.code == POLICY_VIOLATION:
                    _log.warning("the gateway refuses this adapter: %s", closed.reason)
                    backoff = refused
                else:
                    _log.info("the gateway is gone: %s", closed)
        except (InvalidHandshake, ValueError, OSError) as error:
            # A gateway may come later; what an operator has to correct is a warning.
            may_come = _may_come(error)
            said = unreachable(url, error, remedies=(TOKEN_FILE_VARIABLE, CA_FILE_VARIABLE))
            _log.log(news if may_come else logging.WARNING, "%s", said)
            backoff = absent if may_come else refused
        delay = backoff.after(lasted) * chance() + asked
        _log.log(news, "trying again in %.1f s", delay)
        await sleep(delay)


def _may_come(error: Exception) -> bool:
    """Tell whether there is no gateway, or one that starts or ends, as opposed to one that refuses the adapter."""
    if isinstance(error, InvalidStatus):
        return error.response.status_code in _NOT_NOW
    if isinstance(error, InvalidMessage):
        return isinstance(error.__cause__, EOFError)
    return isinstance(error, OSError) and not isinstance(error, ssl.SSLError)
