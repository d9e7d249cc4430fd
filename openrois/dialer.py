"""The adapter's side of the connection to its parent: dial, serve, and dial again for ever."""

import asyncio
import logging
import random
import ssl
import time
from collections.abc import Awaitable, Callable

from websockets.exceptions import InvalidHandshake

from openrois.application import EngineHost
from openrois.backoff import Backoff, asked_to_wait
from openrois.remote.serve import serve_engine
from openrois.transport.credentials import CA_FILE_VARIABLE, NO_CREDENTIALS, TOKEN_FILE_VARIABLE, Credentials
from openrois.transport.stream import POLICY_VIOLATION
from openrois.transport.unreachable import unreachable
from openrois.transport.websocket import dial

__all__ = ["serve_parent"]

_log = logging.getLogger(__name__)


async def serve_parent(
    host: EngineHost,
    url: str,
    *,
    credentials: Credentials = NO_CREDENTIALS,
    sleep: Callable[[float], Awaitable[None]] = asyncio.sleep,
    clock: Callable[[], float] = time.monotonic,
    chance: Callable[[], float] = random.random,
) -> None:
    """Serve an engine to the gateway at `url` until cancelled; a connection that ends is made again.

    Args:
        host: the engine.
        url: `ws://host:port/adapter` of the gateway.
        credentials: what is shown to the gateway; a token is read at every attempt.
        sleep: waits for some seconds between attempts: up to 1 s, then half as long again each time, at most 5 s, and
            by chance less, so that a fleet does not come at once; longer by what a gateway that restarts asks for.
        clock: monotonic seconds, to tell a connection that lasted from one that was refused.
        chance: a number from 0 up to 1.

    Raises:
        websockets.exceptions.InvalidURI: `url` is no WebSocket address.
    """
    backoff = Backoff(limit=5.0)
    while True:
        lasted, asked = 0.0, 0.0
        try:
            async with dial(url, credentials=credentials) as stream:
                _log.info("connected to %s", url)
                connected = clock()
                closed = await serve_engine(host, stream, credentials)
                lasted, asked = clock() - connected, asked_to_wait(closed.reason)
                if closed.code == POLICY_VIOLATION:
                    _log.warning("the gateway refuses this adapter: %s", closed.reason)
                else:
                    _log.info("the gateway is gone: %s", closed)
        except (InvalidHandshake, ValueError, OSError) as error:
            # A gateway may come later; what has to be set right by somebody is a warning.
            waits = isinstance(error, OSError) and not isinstance(error, ssl.SSLError)
            said = unreachable(url, error, remedies=(TOKEN_FILE_VARIABLE, CA_FILE_VARIABLE))
            _log.log(logging.INFO if waits else logging.WARNING, "%s", said)
        delay = backoff.after(lasted) * chance() + asked
        _log.info("trying again in %.1f s", delay)
        await sleep(delay)
