"""Connections for tests: a bus served over memory or over a real WebSocket, and an application's end of a session."""

import asyncio
from collections.abc import AsyncIterator
from contextlib import AsyncExitStack, asynccontextmanager
from dataclasses import dataclass, field
from typing import Any

from openrois.aio.tasks import TaskScope
from openrois.contract import ComponentBus
from openrois.engine.engine import Engine
from openrois.gateway.adapters import serve_adapter
from openrois.gateway.applications import serve_application
from openrois.jsonrpc.session import NotificationHandler, RpcSession
from openrois.remote.proxy import RemoteProxy
from openrois.remote.serve import serve_engine
from openrois.session.session import EngineHost
from openrois.transport.memory import memory_pair
from openrois.transport.stream import MessageStream


async def no_wait(_seconds: float) -> None:
    """Stand in for a clock whose time passes at once."""


@asynccontextmanager
async def hosted(engine: Engine) -> AsyncIterator[EngineHost]:
    async with TaskScope() as tasks:
        yield EngineHost(engine, tasks, sleep=no_wait)


@asynccontextmanager
async def engine_over(*buses: ComponentBus, engine_id: str = "gateway") -> AsyncIterator[Engine]:
    engine = Engine(engine_id)
    for bus in buses:
        await engine.attach(bus)
    yield engine


@asynccontextmanager
async def proxied(
    engine: Engine, streams: tuple[MessageStream, MessageStream] | None = None
) -> AsyncIterator[RemoteProxy]:
    """Serve `engine` on one end of a connection and yield the proxy on the other."""
    near, far = streams or memory_pair()
    session = RpcSession(near)
    async with hosted(engine) as host, TaskScope() as questions, asyncio.TaskGroup() as tasks:
        proxy = RemoteProxy(session, lambda: None, questions)
        session.notifications = proxy.notifications()
        serving = tasks.create_task(serve_engine(host, far))
        running = tasks.create_task(session.run())
        running.add_done_callback(lambda _task: proxy.lost("the connection has ended"))
        try:
            await proxy.discover()
            yield proxy
        finally:
            await near.close()
            await asyncio.wait({serving, running}, timeout=5)


@dataclass
class Application:
    """An application's end: sends requests, and keeps what it receives."""

    session: RpcSession
    told: asyncio.Queue[tuple[str, dict[str, Any]]] = field(default_factory=asyncio.Queue)

    async def ask(self, method: str, **params: Any) -> dict[str, Any]:
        answer: dict[str, Any] = await self.session.call(method, params, timeout=60)
        return answer

    def taking(self, method: str) -> NotificationHandler:
        """Return a handler that keeps notifications of `method`."""
        return lambda params: self.told.put_nowait((method, params))

    async def next(self, method: str) -> dict[str, Any]:
        """Return the next notification of `method`, passing over others."""
        async with asyncio.timeout(60):
            while True:
                name, params = await self.told.get()
                if name == method:
                    return params


NOTIFICATIONS = (
    "rois.command.completed",
    "rois.event.notify_event",
    "rois.system.profile_changed",
    "rois.system.notify_error",
    "openrois.events_dropped",
    "rois.stream.notify_stream_status",
    "signaling.offer",
    "signaling.candidate",
    "signaling.capture_clocks",
    "signaling.bye",
)


@asynccontextmanager
async def application(host: EngineHost) -> AsyncIterator[Application]:
    """Connect an application to the gateway's side of `host` over memory."""
    near, far = memory_pair()
    app = Application(RpcSession(near))
    app.session.notifications = {name: app.taking(name) for name in NOTIFICATIONS}
    async with asyncio.TaskGroup() as tasks:
        serving = tasks.create_task(serve_application(host, far))
        running = tasks.create_task(app.session.run())
        try:
            yield app
        finally:
            await near.close()
            await asyncio.wait({serving, running}, timeout=5)


@asynccontextmanager
async def adapter_leg(host: EngineHost, below: Engine | EngineHost) -> AsyncIterator[MessageStream]:
    """Attach an engine to the gateway's `host` as an adapter over memory; yields the adapter's end."""
    near, far = memory_pair()
    changed = asyncio.Event()
    stop = host.engine.on_change(changed.set)
    async with AsyncExitStack() as stack:
        adapter_host = await stack.enter_async_context(hosted(below)) if isinstance(below, Engine) else below
        tasks = await stack.enter_async_context(asyncio.TaskGroup())
        serving = tasks.create_task(serve_adapter(host, near))
        served = tasks.create_task(serve_engine(adapter_host, far))
        try:
            async with asyncio.timeout(60):
                await changed.wait()
            stop()
            yield far
        finally:
            await far.close()
            await asyncio.wait({serving, served}, timeout=5)
