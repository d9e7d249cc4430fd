"""`GET /metrics`: a small HTTP server of its own, for Prometheus."""

import asyncio
import errno
import hmac
from collections.abc import AsyncIterator, Awaitable, Callable, Mapping
from contextlib import AsyncExitStack, asynccontextmanager
from functools import partial
from types import MappingProxyType
from typing import Final

from aiohttp import web

from openrois.http_limits.header_timeout import OPTIONS, Connection, HeaderTimeouts
from openrois.http_limits.tcp_server import serving_tcp

__all__ = ["LOOPBACK", "MetricsUnavailable", "metrics_address", "serving_metrics"]

LOOPBACK: Final = "127.0.0.1"

MAX_SCRAPES: Final = 16
"""Requests for figures at a time, one of which is answered; one more is answered 503."""

_SHUTDOWN_TIMEOUT: Final = 0.5


class MetricsUnavailable(Exception):
    """Figures cannot be served at that address; the text says why."""


def metrics_address(text: str) -> tuple[str, int]:
    """Read `HOST:PORT`, `[HOST]:PORT`, `:PORT` or `PORT`; without a host it is the loopback address.

    Raises:
        ValueError: it is none of these.
    """
    host, _, port = text.rpartition(":")
    host = host.removeprefix("[").removesuffix("]") or LOOPBACK
    if not (port.isascii() and port.isdigit() and int(port) < 2**16):
        raise ValueError(f"{text!r} is no address for metrics: write it as HOST:PORT or PORT")
    return host, int(port)


@asynccontextmanager
async def serving_metrics(
    host: str,
    port: int,
    write: Callable[[str], Awaitable[tuple[bytes, str]]],
    token: str = "",
    turned_away: Callable[[str], None] = lambda _reason: None,
    beside: Mapping[str, Callable[[web.Request], Awaitable[web.StreamResponse]]] = MappingProxyType({}),
) -> AsyncIterator[str]:
    """Serve figures while the block runs; yields the URL, with the port that was chosen for 0.

    Args:
        host: the address to listen on.
        port: the TCP port.
        write: given the header `Accept`, returns all figures and the content type; never called twice at a time.
        token: what a client has to show, as `Authorization: Bearer`; empty for nothing.
        turned_away: called with the reason whenever a connection is cut, or a request refused for being one too many.
        beside: handlers of other paths of the same port, without a token.

    Raises:
        MetricsUnavailable: the port is taken, or the address is not this machine's.
    """
    one_at_a_time = asyncio.Lock()
    scrapes = 0
    header_timeouts = HeaderTimeouts(turned_away)

    async def answer(request: web.Request) -> web.Response:
        shown = request.headers.get("Authorization", "")
        is_it = hmac.compare_digest(shown.encode(errors="surrogateescape"), f"Bearer {token}".encode())
        if token and not is_it:
            raise web.HTTPUnauthorized(headers={"WWW-Authenticate": "Bearer"})
        nonlocal scrapes
        if scrapes >= MAX_SCRAPES:
            turned_away("full")
            raise web.HTTPServiceUnavailable
        scrapes += 1
        try:
            async with one_at_a_time:
                text, content_type = await write(request.headers.get("Accept", ""))
        finally:
            scrapes -= 1
        return web.Response(body=text, headers={"Content-Type": content_type})

    app = web.Application(middlewares=[header_timeouts.middleware()])
    app.router.add_get("/metrics", answer)
    for path, handler in beside.items():
        app.router.add_get(path, handler)
    runner = web.AppRunner(app, shutdown_timeout=_SHUTDOWN_TIMEOUT)
    await runner.setup()
    assert runner.server is not None
    loop = asyncio.get_running_loop()
    connections = partial(Connection, runner.server, header_timeouts, loop=loop, **OPTIONS)
    async with AsyncExitStack() as stack:
        stack.push_async_callback(runner.cleanup)
        try:
            chosen = await stack.enter_async_context(serving_tcp(host, port, header_timeouts, connections))
        except OSError as error:
            raise MetricsUnavailable(f"metrics cannot be served at {host}:{port}: {_why(error)}") from error
        yield f"http://{f'[{host}]' if ':' in host else host}:{chosen}/metrics"


def _why(error: OSError) -> str:
    return "the port is taken" if error.errno == errno.EADDRINUSE else error.strerror or str(error)
