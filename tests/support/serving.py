"""The gateway's side of WebSockets on a port of their own, without a gateway."""

import asyncio
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import AsyncExitStack, asynccontextmanager
from functools import partial

from aiohttp import web

from openrois.gateway.socket import APPLICATION, ServerSocket, SocketProfile
from openrois.http_limits.header_timeout import HeaderTimeouts
from openrois.http_limits.http_connection import HttpConnection
from openrois.http_limits.tcp_server import serving_tcp


@asynccontextmanager
async def serving(
    serve: Callable[[ServerSocket], Awaitable[object]], profile: SocketProfile = APPLICATION
) -> AsyncIterator[str]:
    """Serve all connections; yields the address."""

    async def accept(request: web.Request) -> web.StreamResponse:
        socket = ServerSocket(request, profile)
        await socket.prepare()
        await serve(socket)
        return socket.response

    header_timeouts = HeaderTimeouts(lambda _reason: None)
    app = web.Application(middlewares=[header_timeouts.middleware()])
    app.router.add_get("/", accept)
    async with AsyncExitStack() as stack:
        runner = web.AppRunner(app, access_log=None, shutdown_timeout=0.1)
        await runner.setup()
        stack.push_async_callback(runner.cleanup)
        assert runner.server is not None
        loop = asyncio.get_running_loop()
        connections = partial(HttpConnection, runner.server, header_timeouts, loop=loop)
        port = await stack.enter_async_context(serving_tcp("127.0.0.1", 0, header_timeouts, connections))
        yield f"ws://127.0.0.1:{port}/"
