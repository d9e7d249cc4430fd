"""A gateway, an adapter and applications in one process: the whole wire, and no socket."""

import asyncio
from collections.abc import AsyncIterator
from contextlib import AsyncExitStack, asynccontextmanager
from dataclasses import dataclass
from typing import Final

from openrois.aio.tasks import TaskScope
from openrois.client import Client
from openrois.component.component import Component
from openrois.engine.engine import Engine
from openrois.engine.registry import LocalRegistry
from openrois.gateway.adapters import serve_adapter
from openrois.gateway.applications import serve_application
from openrois.remote.serve import serve_engine
from openrois.session.session import EngineHost
from openrois.transport.memory import memory_pair
from openrois.transport.stream import MessageStream

__all__ = ["MemoryGateway", "harness", "memory_gateway"]

PATIENCE: Final = 5.0
"""Seconds after which something that comes at once has not come."""


@dataclass(frozen=True, slots=True)
class MemoryGateway:
    """A gateway in memory.

    Attributes:
        host: its engine, and what its sessions share.
        patience: seconds that an answer may take.
    """

    host: EngineHost
    patience: float = PATIENCE

    @property
    def engine(self) -> Engine:
        """The main HRI engine; a `ComponentBus`."""
        return self.host.engine

    @asynccontextmanager
    async def dial(self) -> AsyncIterator[MessageStream]:
        """Connect one more application while the block runs."""
        near, far = memory_pair()
        serving = asyncio.ensure_future(serve_application(self.host, near))
        try:
            yield far
        finally:
            await far.close()
            await asyncio.wait({serving}, timeout=self.patience)

    def client(self) -> Client:
        """Return one more application, to be entered: `async with gateway.client() as client`."""
        return Client(dial=self.dial, connect_timeout=self.patience, request_timeout=self.patience, reconnect=None)


@asynccontextmanager
async def memory_gateway(
    *components: Component, engine_id: str = "robot", patience: float = PATIENCE
) -> AsyncIterator[MemoryGateway]:
    """Run an adapter behind a gateway while the block runs: the real code, connected in memory.

    Each component is connected first; one whose `connect` fails is in ERROR, as its status tells.

    Args:
        components: the adapter's.
        engine_id: of the adapter: a component is `<engine_id>/<name>`.
        patience: seconds that an answer may take.

    Raises:
        BadParameter: `engine_id` or a component's name cannot be part of a reference, or a name stands twice.
    """
    registry = LocalRegistry(engine_id, components)
    async with AsyncExitStack() as stack:
        for component in components:
            await component.bring_up()
            stack.push_async_callback(component.take_down)
        adapter = EngineHost(Engine(engine_id), await stack.enter_async_context(TaskScope()))
        await adapter.engine.attach(registry)
        gateway = EngineHost(Engine("gateway"), await stack.enter_async_context(TaskScope()))
        await stack.enter_async_context(_attached(gateway, adapter, patience))
        yield MemoryGateway(gateway, patience)


@asynccontextmanager
async def _attached(gateway: EngineHost, adapter: EngineHost, patience: float) -> AsyncIterator[None]:
    changed = asyncio.Event()
    stop_listening = gateway.engine.on_change(changed.set)
    near, far = memory_pair()
    serving = {
        asyncio.ensure_future(serve_adapter(gateway, near)),
        asyncio.ensure_future(serve_engine(adapter, far)),
    }
    try:
        async with asyncio.timeout(patience):
            await changed.wait()
        stop_listening()
        yield
    finally:
        await far.close()
        await asyncio.wait(serving, timeout=patience)


@asynccontextmanager
async def harness(
    *components: Component, engine_id: str = "robot", patience: float = PATIENCE
) -> AsyncIterator[Client]:
    """Run components behind a gateway in memory, and yield an application that is connected to it.

    Args:
        components: as `memory_gateway` takes them.
        engine_id: of the adapter: a component is `<engine_id>/<name>`.
        patience: seconds that an answer may take.

    Raises:
        BadParameter: `engine_id` or a component's name cannot be part of a reference, or a name stands twice.
    """
    async with (
        memory_gateway(*components, engine_id=engine_id, patience=patience) as gateway,
        gateway.client() as client,
    ):
        yield client
