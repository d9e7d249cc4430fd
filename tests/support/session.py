"""One session, and its other side played by hand."""

import asyncio
import json
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any

from openrois.jsonrpc.outbox import Outbox
from openrois.jsonrpc.session import Handler, NotificationHandler, RpcSession
from openrois.transport.memory import MemoryStream, memory_pair
from openrois.transport.stream import StreamClosed


class Other:
    """The other side: raw messages, by hand."""

    def __init__(self, session: RpcSession, stream: MemoryStream, running: asyncio.Task[StreamClosed]) -> None:
        self.session = session
        self.stream = stream
        self.running = running

    async def say(self, **message: Any) -> None:
        await self.stream.send(json.dumps({"jsonrpc": "2.0", **message}))

    async def hear(self) -> dict[str, Any]:
        async with asyncio.timeout(60):
            message: dict[str, Any] = json.loads(await self.stream.receive())
        assert message.pop("jsonrpc") == "2.0"
        return message

    async def ended(self) -> StreamClosed:
        async with asyncio.timeout(60):
            return await asyncio.shield(self.running)


@asynccontextmanager
async def connected(
    methods: dict[str, Handler] | None = None,
    notifications: dict[str, NotificationHandler] | None = None,
    *,
    outbox: Outbox | None = None,
    capacity: int = 64,
) -> AsyncIterator[Other]:
    near, far = memory_pair(capacity)
    session = RpcSession(near, methods or {}, notifications or {}, outbox if outbox is not None else Outbox())
    running = asyncio.ensure_future(session.run())
    try:
        yield Other(session, far, running)
    finally:
        far.abort()
        async with asyncio.timeout(60):
            await running


async def settle() -> None:
    """Let everything run that can run without anything new from outside."""
    for _ in range(20):
        await asyncio.sleep(0)


def gate() -> tuple[asyncio.Event, Handler]:
    """Return a handler that answers its params once the event is set."""
    opened = asyncio.Event()

    async def handle(params: dict[str, Any]) -> dict[str, Any]:
        await opened.wait()
        return params

    return opened, handle


async def echo(params: dict[str, Any]) -> dict[str, Any]:
    return params
