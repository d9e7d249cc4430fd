"""A bad network in front of an engine: applications connect here, and their media passes through an `ImpairedPath`."""

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import aiohttp
from aiohttp import WSMsgType, web
from openrois_streaming.testing import ImpairedPath, Impairments


@asynccontextmanager
async def impaired(engine: str, down: Impairments, up: Impairments) -> AsyncIterator[tuple[str, ImpairedPath]]:
    """Serve one application; yields the address of its WebSocket, and the path.

    Args:
        engine: the address of the WebSocket that speaks for the engine.
        down: what happens to what the engine sends.
        up: what happens to what the application sends.
    """
    async with ImpairedPath(down, up) as path, aiohttp.ClientSession() as client:

        async def pass_on(request: web.Request) -> web.WebSocketResponse:
            application = web.WebSocketResponse()
            await application.prepare(request)
            async with client.ws_connect(engine) as behind:

                async def downwards() -> None:
                    async for message in behind:
                        if message.type is WSMsgType.TEXT:
                            await application.send_str(path.to_viewer(message.data))

                passing = asyncio.create_task(downwards())
                async for message in application:
                    if message.type is WSMsgType.TEXT:
                        await behind.send_str(path.to_engine(message.data))
                passing.cancel()
            return application

        app = web.Application()
        app.router.add_get("/", pass_on)
        runner = web.AppRunner(app, access_log=None, shutdown_timeout=0.5)
        await runner.setup()
        try:
            await web.TCPSite(runner, "127.0.0.1", 0).start()
            yield f"ws://127.0.0.1:{runner.addresses[0][1]}/", path
        finally:
            await runner.cleanup()
