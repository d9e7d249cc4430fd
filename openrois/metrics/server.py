"""`GET /metrics`: a small HTTP server of its own, for Prometheus."""

import asyncio
import errno
import hmac
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import asynccontextmanager
from typing import Final

from aiohttp import web

from openrois.http_log import HTTP_LOG

__all__ = ["LOOPBACK", "MetricsUnavailable", "metrics_address", "serving_metrics"]

LOOPBACK: Final = "127.0.0.1"

_SHUTDOWN_TIMEOUT: Final = 0.5


class MetricsUnavailable(Exception):
    """Figures cannot be served where they should be; the text says why."""


def metrics_address(text: str) -> tuple[str, int]:
    """Read `HOST:PORT`, `[HOST]:PORT`, `:PORT` or `PORT`; without a host it is the loopback address.

    Raises:
        ValueError: it is none of these.
    """
    host, _, port = text.rpartition(":")
    host = host.removeprefix("[").removesuffix("]") or LOOPBACK
    if not (port.isascii() and port.isdigit() and int(port) < 2**16):
        raise ValueError(f"{text!r} is no address for metrics: HOST:PORT or PORT")
    return host, int(port)


@asynccontextmanager
async def serving_metrics(
    host: str, port: int, write: Callable[[str], Awaitable[tuple[bytes, str]]], token: str = ""
) -> AsyncIterator[str]:
    """Serve figures for as long as the block runs; gives the URL, with the port that was chosen for 0.

    Args:
        host: the address to listen on.
        port: the TCP port.
        write: given the header `Accept`, returns all figures and the content type; never called twice at a time.
        token: what whoever asks has to show, as `Authorization: Bearer`; empty for nothing.

    Raises:
        MetricsUnavailable: the port is taken, or the address is not this machine's.
    """
    one_at_a_time = asyncio.Lock()

    async def answer(request: web.Request) -> web.Response:
        shown = request.headers.get("Authorization", "")
        is_it = hmac.compare_digest(shown.encode(errors="surrogateescape"), f"Bearer {token}".encode())
        if token and not is_it:
            raise web.HTTPUnauthorized(headers={"WWW-Authenticate": "Bearer"})
        async with one_at_a_time:
            text, content_type = await write(request.headers.get("Accept", ""))
        return web.Response(body=text, headers={"Content-Type": content_type})

    app = web.Application()
    app.router.add_get("/metrics", answer)
    runner = web.AppRunner(app, access_log=None, logger=HTTP_LOG, shutdown_timeout=_SHUTDOWN_TIMEOUT)
    await runner.setup()
    try:
        try:
            await web.TCPSite(runner, host, port).start()
        except OSError as error:
            raise MetricsUnavailable(f"metrics cannot be served at {host}:{port}: {_why(error)}") from error
        chosen = runner.addresses[0][1]
        yield f"http://{f'[{host}]' if ':' in host else host}:{chosen}/metrics"
    finally:
        await runner.cleanup()


def _why(error: OSError) -> str:
    return "the port is taken" if error.errno == errno.EADDRINUSE else error.strerror or str(error)
