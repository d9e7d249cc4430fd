"""Gateways that share a store, without their ports, and adapters that connect to them: all in one process."""

import asyncio
from collections.abc import AsyncIterator, Callable
from contextlib import AsyncExitStack, asynccontextmanager
from dataclasses import dataclass, field

from websockets.asyncio.server import ServerConnection, serve
from websockets.exceptions import ConnectionClosed

from openrois.aio.tasks import TaskScope
from openrois.engine.engine import Engine
from openrois.engine.registry import LocalRegistry
from openrois.gateway.adapters import serve_adapter
from openrois.gateway.claims import GatewayClaims
from openrois.leases.epochs import ClaimedEpochs
from openrois.ownership.directorate import Directorate
from openrois.ownership.memory_store import MemoryStore
from openrois.remote.serve import serve_engine
from openrois.session.session import EngineHost
from openrois.transport.memory import MemoryStream, memory_pair
from openrois.transport.stream import StreamClosed, close_reason
from tests.support.clock import Clock
from tests.support.components import Lamp
from tests.support.lossy_store import LossyStore
from tests.support.ownership import never
from tests.support.session import settle

__all__ = ["Accepted", "Link", "Robot", "Site", "World", "listening", "until"]


async def until(condition: Callable[[], object]) -> None:
    """Let everything run until a condition holds."""
    async with asyncio.timeout(30):
        while not condition():
            await settle()


@dataclass
class Site:
    """A gateway, without its port.

    Attributes:
        waits: the seconds that its claims wait for, until `wake` is set.
    """

    host: EngineHost
    directorate: Directorate
    claims: GatewayClaims
    epochs: ClaimedEpochs
    store: LossyStore
    wake: asyncio.Event
    waits: list[float] = field(default_factory=list)

    @property
    def engines(self) -> tuple[str, ...]:
        return self.host.engine.directory.profile.engine_ids()[1:]


@dataclass
class Robot:
    """The process of an adapter."""

    host: EngineHost

    @asynccontextmanager
    async def connected(self, site: Site) -> AsyncIterator["Link"]:
        """Serve it to a gateway while the block runs."""
        near, far = memory_pair()
        gateway = asyncio.ensure_future(serve_adapter(site.host, near, ownership=site.claims))
        link = Link(far, gateway, asyncio.ensure_future(serve_engine(self.host, far)))
        try:
            yield link
        finally:
            await link.leave()


@dataclass
class Link:
    """A connection of an adapter with a gateway."""

    stream: MemoryStream
    gateway: "asyncio.Future[StreamClosed]"
    adapter: "asyncio.Future[StreamClosed]"

    async def leave(self) -> None:
        """Disconnect in good order."""
        await self.stream.close()
        await self.ended()

    async def lose(self) -> None:
        """Lose the connection."""
        self.stream.abort()
        await self.ended()

    async def ended(self) -> StreamClosed:
        """Wait until both sides know that it has ended; return what the adapter was told."""
        async with asyncio.timeout(30):
            await asyncio.wait({self.gateway})
            return await asyncio.shield(self.adapter)


class World:
    """Gateways and adapters in one process."""

    def __init__(self, stack: AsyncExitStack, store: MemoryStore) -> None:
        self.store = store
        self._stack = stack

    async def site(self, gateway_id: str) -> Site:
        """Begin as a gateway, which renews when it is told to."""
        wake, waits = asyncio.Event(), list[float]()

        async def sleep(seconds: float) -> None:
            waits.append(seconds)
            await wake.wait()

        async def soon(_seconds: float) -> None:
            await asyncio.sleep(0)

        store = LossyStore(self.store)
        directorate = Directorate(store, gateway_id, patience=60.0, clock=Clock(1000.0), sleep=never)
        await self._stack.enter_async_context(directorate)
        tasks = await self._stack.enter_async_context(TaskScope())
        epochs = ClaimedEpochs(lambda: directorate.problem)
        host = EngineHost(Engine("gateway"), tasks, sleep=soon, epochs=epochs)
        claims = GatewayClaims(host.engine, directorate, epochs, sleep=sleep)
        await self._stack.enter_async_context(claims)
        return Site(host, directorate, claims, epochs, store, wake, waits)

    async def robot(self, *engine_ids: str) -> Robot:
        """Start an adapter process with a lamp on each of its engines."""
        engine = Engine(engine_ids[0] if engine_ids else "robot")
        for engine_id in engine_ids or ("robot",):
            await engine.attach(LocalRegistry(engine_id, [Lamp()]))
        return Robot(EngineHost(engine, await self._stack.enter_async_context(TaskScope())))


class Accepted:
    """A WebSocket that a gateway has accepted, as a `MessageStream`."""

    def __init__(self, connection: ServerConnection) -> None:
        self._connection = connection

    async def receive(self) -> str:
        try:
            return str(await self._connection.recv())
        except ConnectionClosed as closed:
            frame = closed.rcvd or closed.sent
            raise StreamClosed(*((1006,) if frame is None else (frame.code, frame.reason))) from None

    async def send(self, text: str) -> None:
        try:
            await self._connection.send(text)
        except ConnectionClosed:
            raise StreamClosed(1006) from None

    async def close(self, code: int = 1000, reason: str = "") -> None:
        await self._connection.close(code, close_reason(reason))

    def abort(self) -> None:
        self._connection.transport.abort()


@asynccontextmanager
async def listening(site: Site, streams: list[Accepted]) -> AsyncIterator[str]:
    """Take adapters by WebSocket, whose streams are kept; yield the address."""

    async def take(far: ServerConnection) -> None:
        stream = Accepted(far)
        streams.append(stream)
        await serve_adapter(site.host, stream, ownership=site.claims)

    async with serve(take, "127.0.0.1", 0) as server:
        yield f"ws://127.0.0.1:{server.sockets[0].getsockname()[1]}/adapter"
