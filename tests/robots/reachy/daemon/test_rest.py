"""Requests to a daemon: what fails, fails in a sentence that says why and what to do."""

import asyncio
import errno
import socket
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any

import aiohttp
import pytest
from aiohttp import web
from openrois_robots.reachy.daemon.address import REMEDY, Address
from openrois_robots.reachy.daemon.rest import Daemon, DaemonSilent, DaemonUnreachable, unreachable, within

from openrois.errors import ComponentFailed

pytestmark = pytest.mark.extra(name="reachy")


class Connecting(OSError):
    """What a library makes of an error of the system."""

    def __init__(self, error: OSError) -> None:
        super().__init__(error.errno, "Cannot connect to host")
        self.os_error = error


@pytest.mark.parametrize(
    ("error", "reason"),
    [
        (OSError(errno.ECONNREFUSED, "no"), "nothing listens at this port"),
        (Connecting(OSError(errno.EHOSTUNREACH, "no")), "there is no way to it in the network"),
        (Connecting(socket.gaierror(-2, "no")), "this name is not known in the network"),
        (OSError("something else"), "something else"),
        (OSError(), "it has closed the connection"),
    ],
)
def test_why_a_daemon_cannot_be_reached_is_a_sentence_with_a_remedy(error: OSError, reason: str) -> None:
    assert unreachable(error) == f"{reason}; {REMEDY}"


@asynccontextmanager
async def answering(answer: web.Response) -> AsyncIterator[Daemon]:
    """Ask a server that answers everything so."""

    async def handle(_request: web.Request) -> web.Response:
        return answer

    application = web.Application()
    application.router.add_get("/status", handle)
    runner = web.AppRunner(application, access_log=None)
    await runner.setup()
    try:
        await web.TCPSite(runner, "127.0.0.1", 0).start()
        async with Daemon(Address("127.0.0.1", runner.addresses[0][1])) as daemon:
            yield daemon
    finally:
        await runner.cleanup()


@pytest.mark.parametrize(
    ("answer", "kind", "sentence"),
    [
        ({"text": "<html>"}, DaemonUnreachable, "what listens there is no daemon of a Reachy Mini, or one that is too"),
        ({"text": '{"detail": "Not Found"}', "status": 404}, DaemonUnreachable, "no daemon of a Reachy Mini"),
        ({"text": "Internal Server Error", "status": 500}, ComponentFailed, "GET /status failed: status 500"),
        ({"text": '{"detail": "Backend not running"}', "status": 503}, ComponentFailed, "failed: Backend not running"),
        ({"text": '{"detail": [{"msg": "x"}]}', "status": 422}, ComponentFailed, "GET /status failed: status 422"),
        ({"text": '{"detail": "Untrusted Host header"}', "status": 400}, DaemonUnreachable, r"ends in \.local only"),
    ],
)
async def test_an_answer_that_is_none_says_why(answer: dict[str, Any], kind: type[Exception], sentence: str) -> None:
    async with answering(web.Response(**answer)) as daemon:
        with pytest.raises(kind, match=sentence):
            await daemon.get("/status")


async def test_an_answer_that_does_not_come_has_an_end() -> None:
    async def wait() -> None:
        await asyncio.Event().wait()

    with pytest.raises(DaemonSilent, match=r"GET /status was not answered within 0\.01 s"):
        await within(0.01, "GET /status", wait)


async def test_a_connection_that_is_closed_and_one_that_is_none_are_said() -> None:
    async def lose() -> None:
        raise aiohttp.ServerDisconnectedError

    async def babble() -> None:
        raise aiohttp.ClientPayloadError

    with pytest.raises(DaemonUnreachable, match="it has closed the connection; check --robot"):
        await within(1, "GET /status", lose)
    with pytest.raises(DaemonUnreachable, match="what listens there is no daemon"):
        await within(1, "GET /status", babble)
