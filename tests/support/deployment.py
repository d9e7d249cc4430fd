"""A real gateway with real adapters on real sockets, and an application on a bare WebSocket."""

import asyncio
import json
from collections.abc import AsyncIterator, Callable
from contextlib import AbstractAsyncContextManager, AsyncExitStack, asynccontextmanager
from dataclasses import dataclass, field
from typing import Any

import pytest
from websockets.asyncio.client import ClientConnection, connect

from openrois.adapter.dialer import serve_parent
from openrois.aio.tasks import TaskScope
from openrois.component.authoring.marks import command, query
from openrois.component.component import Component
from openrois.contract import Extension
from openrois.engine.engine import Engine
from openrois.engine.registry import LocalRegistry
from openrois.federation.cluster_directory import ClusterDirectory
from openrois.gateway.server import Gateway, run_gateway
from openrois.gateway.settings import GatewaySettings
from openrois.gateway.socket import ADAPTER, APPLICATION, SocketProfile
from openrois.jsonrpc.session import RpcSession
from openrois.session.session import EngineHost
from openrois.types.codes import ComponentStatus
from tests.support.components import Bell, Lamp
from tests.support.schema import check_notification, check_result
from tests.support.streams import Camera, FakeStreams

REASON = "openrois.reason"

PATIENCE = 30.0
"""Seconds after which a test gives up waiting for something that comes at once."""


class Door(Component, authority="Test"):
    """A component without a class: opens when allowed, can be out of order, and records its arguments."""

    def __init__(self, name: str = "door") -> None:
        super().__init__(name)
        self.is_in = ComponentStatus.READY
        self.asked = asyncio.Event()
        self.may_answer = asyncio.Event()
        self.may_answer.set()
        self.opened: list[str] = []

    def condition(self) -> ComponentStatus:
        return self.is_in

    @command(result="how")
    async def open(self, how: str | None = None) -> str | None:
        self.asked.set()
        await self.may_answer.wait()
        self.opened.append(how or "")
        return how

    @command
    async def list(self, numbers: tuple[int, ...] | None = None) -> None:
        await self.open()

    @query
    async def view(self) -> str:
        self.asked.set()
        await self.may_answer.wait()
        return "a garden"


@dataclass
class Robot:
    """The components of the adapter `robot`."""

    lamp: Lamp = field(default_factory=Lamp)
    bell: Bell = field(default_factory=Bell)
    door: Door = field(default_factory=Door)
    camera: Camera = field(default_factory=Camera)
    streams: FakeStreams = field(default_factory=FakeStreams)

    def parts(self) -> tuple[Component, ...]:
        return (self.lamp, self.bell, self.door, self.camera)


@dataclass
class Application:
    """An application that speaks raw JSON; each message it gets is checked against the strict wire.

    Attributes:
        reasons: why something was refused or failed, by the request's id or the command's: each stood right before it.
    """

    socket: ClientConnection
    told: list[tuple[str, dict[str, Any]]] = field(default_factory=list)
    answers: dict[Any, dict[str, Any]] = field(default_factory=dict)
    heard: list[dict[str, Any]] = field(default_factory=list)
    last_id: int = 0
    reasons: dict[Any, str] = field(default_factory=dict)

    async def send(self, message: Any) -> None:
        await self.socket.send(message if isinstance(message, str | bytes) else json.dumps(message))

    async def hear(self) -> dict[str, Any]:
        """Return the next message, as it came."""
        async with asyncio.timeout(PATIENCE):
            raw = await self.socket.recv()
        assert isinstance(raw, str)
        message: dict[str, Any] = json.loads(raw)
        assert message["jsonrpc"] == "2.0"
        if self.heard and self.heard[-1].get("method") == REASON:
            self._explain(self.heard[-1]["params"], message)
        self.heard.append(message)
        return message

    def _explain(self, told: dict[str, Any], message: dict[str, Any]) -> None:
        """Keep a reason, and refuse one that does not stand right before what it explains."""
        assert len(told) == 2
        assert 0 < len(told["reason"]) <= 500
        assert told["reason"].isprintable()
        if "request_id" in told:
            assert message["id"] == told["request_id"]
            assert message["result"]["return_code"] != "OK"
            self.reasons[message["id"]] = told["reason"]
        else:
            assert message["method"] == "rois.command.completed"
            assert message["params"]["command_id"] == told["command_id"]
            assert message["params"]["status"] != "OK"
            self.reasons[told["command_id"]] = told["reason"]

    async def begin(self, method: str, **params: Any) -> str:
        """Send a request and return its id."""
        self.last_id += 1
        request_id = f"req-{self.last_id}"
        await self.send({"jsonrpc": "2.0", "id": request_id, "method": method, "params": params})
        return request_id

    async def answer(self, request_id: Any) -> dict[str, Any]:
        """Return the response to a request, keeping what comes before it."""
        while request_id not in self.answers:
            message = await self.hear()
            if "method" in message:
                self._keep(message)
            else:
                assert message["id"] not in self.answers, "a request was answered twice"
                self.answers[message["id"]] = message
        return self.answers[request_id]

    def _keep(self, message: dict[str, Any]) -> None:
        assert set(message) == {"jsonrpc", "method", "params"}
        check_notification(message["method"], message["params"])
        if message["method"] != REASON:
            self.told.append((message["method"], message["params"]))

    async def ask(self, method: str, **params: Any) -> dict[str, Any]:
        """Ask and return the result, checked against the strict wire."""
        response = await self.answer(await self.begin(method, **params))
        assert set(response) == {"jsonrpc", "id", "result"}, response
        result: dict[str, Any] = response["result"]
        check_result(method, result)
        return result

    async def code(self, method: str, **params: Any) -> str:
        """Ask and return the return code."""
        return str((await self.ask(method, **params))["return_code"])

    async def why(self, method: str, **params: Any) -> tuple[str, str]:
        """Ask and return the return code and the reason; no reason is empty."""
        code = await self.code(method, **params)
        return code, self.reasons.get(f"req-{self.last_id}", "")

    async def eventually(self, code: str, method: str, **params: Any) -> None:
        """Ask until the return code is `code`."""
        async with patience():
            while await self.code(method, **params) != code:
                pass

    async def refused(self, method: str, **params: Any) -> dict[str, Any]:
        """Ask what is answered with a JSON-RPC error and return the error."""
        response = await self.answer(await self.begin(method, **params))
        assert set(response) == {"jsonrpc", "id", "error"}, response
        error: dict[str, Any] = response["error"]
        assert set(error) <= {"code", "message", "data"}
        return error

    async def next(self, method: str) -> dict[str, Any]:
        """Return the next notification of `method`; those of other methods stay."""
        while True:
            for index, (name, params) in enumerate(self.told):
                if name == method:
                    del self.told[index]
                    return params
            message = await self.hear()
            assert "method" in message, message
            self._keep(message)

    async def completed(self, *command_ids: str) -> dict[str, str]:
        """Wait until commands have completed and return how; no other may complete meanwhile."""
        ended: dict[str, str] = {}
        while set(ended) != set(command_ids):
            notice = await self.next("rois.command.completed")
            assert notice["command_id"] in command_ids
            assert notice["command_id"] not in ended
            ended[notice["command_id"]] = notice["status"]
        return ended

    async def settled(self) -> list[str]:
        """Send a harmless request; return the notifications up to its response that were not read yet."""
        await self.ask("rois.system.connect")
        return [name for name, _ in self.told]


@asynccontextmanager
async def application(gateway: Gateway, path: str = "", **options: Any) -> AsyncIterator[Application]:
    # What a test does not read yet may not keep the connection from being closed.
    async with connect(gateway.url.replace("http", "ws") + path, max_queue=None, **options) as socket:
        yield Application(socket)


@asynccontextmanager
async def gateway(
    application: SocketProfile = APPLICATION, adapter: SocketProfile = ADAPTER, **settings: Any
) -> AsyncIterator[Gateway]:
    if across is not None:
        async with across(application, adapter, **settings) as pair:
            yield pair
        return
    async with run_gateway(GatewaySettings(port=0, **settings), application=application, adapter=adapter) as running:
        yield running


@dataclass(frozen=True, slots=True)
class Across(Gateway):
    """Two gateways as one: the applications are at the one, the adapters at the other.

    Attributes:
        adapters: the address of the other one.
        seen: what is known of its engines at the first one.
    """

    adapters: str = ""
    seen: ClusterDirectory = field(default_factory=lambda: ClusterDirectory("gateway"))


across: Callable[..., AbstractAsyncContextManager[Across]] | None = None
"""Makes the gateways of tests, where `--across` lets each test have two."""


def adapter_url(gateway: Gateway) -> str:
    """Return where adapters connect to a gateway."""
    url = gateway.adapters if isinstance(gateway, Across) else gateway.url
    return url.replace("http", "ws") + "adapter"


async def told_across(gateway: Gateway, condition: Callable[[Any], bool]) -> None:
    """Wait until a condition holds for the ids of the engines that applications see."""
    if isinstance(gateway, Across):
        changed = asyncio.Event()
        stop = gateway.seen.changes.add(lambda _change: changed.set())
        try:
            async with asyncio.timeout(PATIENCE):
                while not condition(gateway.seen.tree.engine_ids):
                    changed.clear()
                    await changed.wait()
        finally:
            stop()


@dataclass
class Adapter:
    """An adapter that is attached until `stop`; `start` attaches it again."""

    gateway: Gateway
    host: EngineHost
    dialling: asyncio.Task[None] | None = None

    @property
    def subscriptions(self) -> int:
        """How many subscriptions its engine has now."""
        return len(self.host.engine._subscriptions)

    async def start(self) -> None:
        engine_id = self.host.engine.engine_id
        self.dialling = asyncio.ensure_future(serve_parent(self.host, adapter_url(self.gateway)))
        await until(self.gateway.engine, lambda ids: engine_id in ids)
        await told_across(self.gateway, lambda ids: engine_id in ids)

    async def stop(self) -> None:
        assert self.dialling is not None
        self.dialling.cancel()
        await asyncio.wait({self.dialling})
        engine_id = self.host.engine.engine_id
        await until(self.gateway.engine, lambda ids: engine_id not in ids)
        await told_across(self.gateway, lambda ids: engine_id not in ids)


def patience() -> asyncio.Timeout:
    """Bound a wait for something that comes at once."""
    return asyncio.timeout(PATIENCE)


def adapter_sessions(monkeypatch: pytest.MonkeyPatch) -> list[RpcSession]:
    """Return a list of the sessions that the gateway will have with its adapters, to shorten their patience."""
    sessions: list[RpcSession] = []

    def make(*arguments: Any, **options: Any) -> RpcSession:
        sessions.append(RpcSession(*arguments, **options))
        return sessions[-1]

    monkeypatch.setattr("openrois.gateway.adapters.RpcSession", make)
    return sessions


async def until(engine: Engine, condition: Any) -> None:
    """Wait until `condition` holds for the ids of the engine's tree."""
    changed = asyncio.Event()
    stop = engine.on_change(changed.set)
    try:
        async with asyncio.timeout(PATIENCE):
            while not condition(engine.directory.profile.engine_ids()):
                changed.clear()
                await changed.wait()
    finally:
        stop()


async def forever() -> None:
    """Wait for what never comes."""
    await asyncio.Event().wait()


async def no_wait(_seconds: float) -> None:
    """Stand in for a clock whose time passes at once."""


@asynccontextmanager
async def adapter(
    gateway: Gateway, *components: Component, engine_id: str = "robot", extension: Extension | None = None
) -> AsyncIterator[Adapter]:
    """Attach an adapter to a gateway."""
    async with AsyncExitStack() as stack:
        tasks = await stack.enter_async_context(TaskScope())
        engine = Engine(engine_id)
        await engine.attach(LocalRegistry(engine_id, components, extension=extension))
        attached = Adapter(gateway, EngineHost(engine, tasks, sleep=no_wait))
        try:
            await attached.start()
            yield attached
        finally:
            if attached.dialling is not None:
                attached.dialling.cancel()
                await asyncio.wait({attached.dialling})


@asynccontextmanager
async def two_level(above: Adapter, *components: Component, engine_id: str) -> AsyncIterator[Engine]:
    """Attach an engine of its own below an adapter's."""
    below = Engine(engine_id)
    await below.attach(LocalRegistry(engine_id, components))
    await above.host.engine.attach(below)
    yield below
    above.host.engine.detach(below)
