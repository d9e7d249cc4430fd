"""Gateways to try a client on: ours over a socket, ours in memory, and one that speaks the base wire alone."""

import asyncio
import json
from collections.abc import AsyncIterator, Callable, Mapping, Sequence
from contextlib import AsyncExitStack, asynccontextmanager
from dataclasses import dataclass, field
from typing import Any, Final, cast

from websockets.asyncio.server import ServerConnection, serve

from openrois.aio.tasks import TaskScope
from openrois.client import Client, Notice, Reconnect
from openrois.engine.engine import Engine
from openrois.engine.registry import LocalRegistry
from openrois.gateway.applications import serve_application
from openrois.interfaces import base_methods
from openrois.jsonrpc.session import RpcSession
from openrois.leases.model import Rules
from openrois.session.session import ApplicationSession, EngineHost
from openrois.transport.memory import MemoryStream, memory_pair
from openrois.transport.stream import MessageStream, StreamClosed
from openrois.transport.websocket import WebSocketStream
from tests.support.components import Bell, Lamp
from tests.support.fleet import Robot, everything
from tests.support.wire import no_wait

__all__ = ["GROUNDS", "Clock", "Ground", "Line", "deaf", "eventually", "ground", "heard", "line", "serve_plain"]


@dataclass(frozen=True)
class Ground:
    """A gateway with a robot of all basic components, and with a lamp and a bell of the engine `toys`.

    Attributes:
        robot: the engine `robot`.
        lamp, bell: components of types that are in no catalog.
        options: how a client reaches the gateway.
        extended: whether it speaks more than the base wire.
        engine: the gateway's.
    """

    robot: Robot
    lamp: Lamp
    bell: Bell
    options: Mapping[str, Any]
    extended: bool
    engine: Engine

    def client(self, **options: Any) -> Client:
        return Client(**{**self.options, **options})


async def _furnish(engine: Engine) -> tuple[Robot, Lamp, Bell, LocalRegistry]:
    robot, lamp, bell = everything("robot"), Lamp(), Bell()
    toys = LocalRegistry("toys", (lamp, bell))
    await engine.attach(robot.registry)
    await engine.attach(toys)
    return robot, lamp, bell, toys


@asynccontextmanager
async def _ours() -> AsyncIterator[Ground]:
    # The other gateways need no libraries beside those of a client.
    from openrois.gateway.server import run_gateway
    from openrois.gateway.settings import GatewaySettings

    async with run_gateway(GatewaySettings(port=0)) as gateway:
        robot, lamp, bell, _ = await _furnish(gateway.engine)
        yield Ground(robot, lamp, bell, {"url": gateway.url}, True, gateway.engine)


@asynccontextmanager
async def _memory() -> AsyncIterator[Ground]:
    async with line() as running:
        yield Ground(running.robot, running.lamp, running.bell, {"dial": running.dial}, True, running.host.engine)


class _Accepted(WebSocketStream):
    """The other end of a dialled connection: what it sends is not masked, which the library sees to."""

    def send_now(self, text: str) -> bool:
        return False

    async def send_many(self, texts: Sequence[str]) -> None:
        for text in texts:
            await self.send(text)


@asynccontextmanager
async def _plain() -> AsyncIterator[Ground]:
    async with TaskScope() as tasks:
        host = EngineHost(Engine("gateway"), tasks, sleep=no_wait)
        robot, lamp, bell, _ = await _furnish(host.engine)

        async def handle(socket: ServerConnection) -> None:
            await serve_plain(host, _Accepted(cast(Any, socket)))

        async with serve(handle, "127.0.0.1", 0) as server:
            port = next(iter(server.sockets)).getsockname()[1]
            yield Ground(robot, lamp, bell, {"url": f"ws://127.0.0.1:{port}/"}, False, host.engine)


async def serve_plain(host: EngineHost, stream: MessageStream) -> None:
    """Serve the base wire alone: no `openrois.hello`, and events without their results, which may be asked for."""
    session = RpcSession(stream)

    def notify(method: str, params: Mapping[str, Any] | str, *, droppable: bool = False) -> None:
        told: Mapping[str, Any] = json.loads(params) if isinstance(params, str) else params
        kept = {name: value for name, value in told.items() if name != "results"}
        session.notify(method, kept, droppable=droppable)

    app = ApplicationSession(host, notify)
    session.methods = base_methods(app)
    try:
        await session.run()
    finally:
        await app.close()


GROUNDS: Final[Mapping[str, Callable[[], Any]]] = {"gateway": _ours, "plain": _plain, "memory": _memory}


def ground(name: str) -> Any:
    """Return the context manager of a ground."""
    return GROUNDS[name]()


async def eventually(client: Client, condition: Callable[[], bool]) -> None:
    """Wait until something holds that comes of what the client has sent."""
    async with asyncio.timeout(60):
        while not condition():
            await client.search()


@dataclass
class Clock:
    """A clock set by a test: sleeping tasks are woken by `pass_time`.

    Attributes:
        asked: how long each sleep was to be.
        now: monotonic seconds.
    """

    asked: list[float] = field(default_factory=list)
    now: float = 0.0
    _sleepers: list[asyncio.Event] = field(default_factory=list)
    _fell_asleep: asyncio.Event = field(default_factory=asyncio.Event)

    async def sleep(self, seconds: float) -> None:
        self.asked.append(seconds)
        woken = asyncio.Event()
        self._sleepers.append(woken)
        self._fell_asleep.set()
        try:
            await woken.wait()
        finally:
            if woken in self._sleepers:
                self._sleepers.remove(woken)

    async def asleep(self) -> None:
        """Wait until a task sleeps."""
        async with asyncio.timeout(60):
            while not self._sleepers:
                self._fell_asleep.clear()
                await self._fell_asleep.wait()

    async def pass_time(self) -> float:
        """Wait until a task sleeps, let its time pass, and return how long that was."""
        await self.asleep()
        seconds = self.asked[-1]
        self.now += seconds
        while self._sleepers:
            self._sleepers.pop().set()
        return seconds

    def reconnect(self, **options: Any) -> Reconnect:
        """Return reconnecting by this time, and without chance."""
        return Reconnect(sleep=self.sleep, clock=lambda: self.now, random=lambda: 1.0, **options)


@dataclass
class Line:
    """Our gateway in this process, and the line to it, which a test can cut.

    Attributes:
        host: the gateway; a test may put another one in its place.
        dialled: how often it was dialled.
        busy: what dialling raises, while it is set.
        speaks: serves one connection.
    """

    host: EngineHost
    robot: Robot
    lamp: Lamp
    bell: Bell
    toys: LocalRegistry
    tasks: TaskScope
    dialled: int = 0
    busy: Exception | None = None
    speaks: Callable[[EngineHost, MessageStream], Any] = serve_application
    _ends: list[MemoryStream] = field(default_factory=list)
    _nears: list[MemoryStream] = field(default_factory=list)

    @asynccontextmanager
    async def dial(self) -> AsyncIterator[MessageStream]:
        self.dialled += 1
        if self.busy is not None:
            raise self.busy
        near, far = memory_pair()
        self._ends.append(far)
        self._nears.append(near)
        self.tasks.start(self._serve(far))
        try:
            yield near
        finally:
            near.abort()

    async def _serve(self, far: MemoryStream) -> None:
        await self.speaks(self.host, far)

    async def leave(self, code: int) -> None:
        """End every connection at the applications' end, as one that finds the gateway silent does."""
        while self._nears:
            await self._nears.pop().close(code, "no answer to a ping")

    def cut(self) -> None:
        """End every connection without a word."""
        while self._ends:
            self._ends.pop().abort()

    async def hang_up(self, code: int, reason: str = "") -> None:
        """End every connection politely."""
        while self._ends:
            await self._ends.pop().close(code, reason)


@asynccontextmanager
async def line(grace: float = 0) -> AsyncIterator[Line]:
    """Run it.

    Args:
        grace: seconds for which leases survive a connection.
    """
    async with AsyncExitStack() as stack:
        commands = await stack.enter_async_context(TaskScope())
        connections = await stack.enter_async_context(TaskScope())
        host = EngineHost(Engine("gateway"), commands, sleep=no_wait, lease_rules=Rules(grace=grace))
        yield Line(host, *(await _furnish(host.engine)), connections)


async def heard(notices: AsyncIterator[Any], *kinds: type[Notice]) -> list[Notice]:
    """Return the next notices, which are of these kinds."""
    async with asyncio.timeout(60):
        found = [await anext(notices) for _ in kinds]
    assert [type(each) for each in found] == list(kinds)
    return found


@asynccontextmanager
async def deaf(line: Line) -> AsyncIterator[Any]:
    """Let the gateway answer nothing but the greeting; yields a wait for a method to be asked."""
    asked: dict[str, asyncio.Event] = {}
    usual = line.speaks

    async def speak(_host: Any, stream: MessageStream) -> None:
        while True:
            try:
                message = json.loads(await stream.receive())
            except StreamClosed:
                return
            result = {"return_code": "OK"}
            if message["method"] in ("rois.system.connect", "openrois.hello", "rois.system.disconnect"):
                await stream.send(json.dumps({"jsonrpc": "2.0", "id": message["id"], "result": result}))
            asked.setdefault(message["method"], asyncio.Event()).set()

    async def wait_for(method: str) -> None:
        async with asyncio.timeout(60):
            await asked.setdefault(method, asyncio.Event()).wait()

    line.speaks = speak
    try:
        yield wait_for
    finally:
        line.speaks = usual
