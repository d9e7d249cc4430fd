"""Applications of several principals at one gateway: their messages as texts, and the components they reach."""

import asyncio
import json
from collections.abc import AsyncIterator, Callable, Collection, Mapping
from contextlib import AsyncExitStack, asynccontextmanager
from dataclasses import dataclass, field
from typing import Any, Final, cast

from openrois.aio.tasks import TaskScope
from openrois.auth.principal import Principal, Role
from openrois.catalog.basic import BASIC_COMPONENTS
from openrois.catalog.component_type import ComponentType
from openrois.contract import Client, Sink
from openrois.engine.engine import Engine
from openrois.engine.registry import LocalRegistry
from openrois.gateway.applications import serve_application
from openrois.gateway.token_expiry import TokenExpiry
from openrois.observability.audit import Audit
from openrois.session.session import EngineHost
from openrois.transport.memory import memory_pair
from openrois.transport.stream import MessageStream
from openrois.types.messages import Argument, Result
from openrois.types.streams import HolderNotification
from tests.support.fleet import Part, Robot
from tests.support.streams import FakeStreams

__all__ = ["Place", "Watched", "Wire", "place", "principal"]

PATIENCE: Final = 30.0


def principal(role: Role | str | None, *scope: str, subject: str = "anna", rank: str = "") -> Principal:
    """Return a principal with one role, or with none, and a scope."""
    return Principal(subject, frozenset() if role is None else frozenset({Role(role)}), scope, rank=rank)


class Watched:
    """A bus of a robot's basic components that notes each call.

    Args:
        engine_id: its name.
        kinds: the types of its components; all seventeen, unless others are given.

    Attributes:
        reached: what was called here, and of which component.
    """

    def __init__(self, engine_id: str, kinds: Collection[ComponentType] = BASIC_COMPONENTS) -> None:
        parts = {kind.code: Part(kind) for kind in kinds}
        self.robot = Robot(LocalRegistry(engine_id, cast(Any, parts.values())), parts)
        self.streams = FakeStreams(engine_id)
        self.reached: list[tuple[str, str]] = []
        self.extension = self

    async def discover(self) -> Any:
        return await self.robot.registry.discover()

    async def query(self, component_ref: str, query_type: str) -> tuple[Result, ...]:
        self.reached.append(("query", component_ref))
        return await self.robot.registry.query(component_ref, query_type)

    async def invoke(
        self, component_ref: str, command_type: str, arguments: tuple[Argument, ...] = (), command_id: str = ""
    ) -> tuple[Result, ...]:
        self.reached.append(("invoke", component_ref))
        return await self.robot.registry.invoke(component_ref, command_type, arguments)

    async def subscribe(self, component_ref: str, event_type: str, sink: Sink) -> str:
        self.reached.append(("subscribe", component_ref))
        return await self.robot.registry.subscribe(component_ref, event_type, sink)

    async def unsubscribe(self, subscribe_id: str) -> None:
        await self.robot.registry.unsubscribe(subscribe_id)

    @property
    def takes_role(self) -> bool:
        return self.streams.takes_role

    def engines(self) -> frozenset[str]:
        return self.streams.engines()

    async def call(self, method: str, params: Mapping[str, Any], client: Client) -> dict[str, Any]:
        if "component_ref" in params:
            self.reached.append((method, params["component_ref"]))
        return await self.streams.call(method, params, client)

    async def set_holder(self, notification: HolderNotification, client: Client) -> None:
        await self.streams.set_holder(notification, client)

    async def forget_client(self, client: Client) -> None:
        await self.streams.forget_client(client)


@dataclass
class Wire:
    """An application that sends and receives texts, in memory or over a socket.

    Attributes:
        frames: everything that came and was not looked at yet.
    """

    stream: MessageStream
    frames: list[str] = field(default_factory=list)
    _numbers: int = 0

    async def ask(self, method: str, params: Any) -> list[str]:
        """Ask, and return everything that comes until the answer, which is the last; every request has the same id."""
        await self.stream.send(json.dumps({"jsonrpc": "2.0", "id": 1, "method": method, "params": params}))
        frames = []
        async with asyncio.timeout(PATIENCE):
            while True:
                frames.append(await self.stream.receive())
                if "id" in json.loads(frames[-1]):
                    return frames

    async def result(self, method: str, params: Any) -> dict[str, Any]:
        """Ask, and return the result, or the error as `{"error": code}`."""
        frames = await self.ask(method, params)
        self.frames += frames[:-1]
        answer = json.loads(frames[-1])
        result: dict[str, Any] = answer.get("result") or {"error": answer["error"]["code"]}
        return result

    async def code(self, method: str, params: Any) -> str | int:
        """Ask, and return the return_code, or the code of the error."""
        result = await self.result(method, params)
        code: str | int = result["error"] if "error" in result else result["return_code"]
        return code

    async def until(self, method: str, fits: Callable[[dict[str, Any]], bool] = lambda _params: True) -> dict[str, Any]:
        """Return the params of the next notification of a method that fits; others are passed over."""
        async with asyncio.timeout(PATIENCE):
            while True:
                frame = json.loads(self.frames.pop(0) if self.frames else await self.stream.receive())
                params: dict[str, Any] = frame.get("params", {})
                if frame.get("method") == method and fits(params):
                    return params

    async def completed(self, command_id: str) -> str:
        """Return how a command ended."""
        told = await self.until("rois.command.completed", lambda params: params["command_id"] == command_id)
        return str(told["status"])


@dataclass
class Place:
    """A gateway with its robots.

    Attributes:
        host: the gateway's engine.
        robots: by engine id.
    """

    host: EngineHost
    robots: dict[str, Watched]

    @asynccontextmanager
    async def application(self, who: Principal | TokenExpiry) -> AsyncIterator[Wire]:
        """Connect an application of a principal, which a new token can change."""
        near, far = memory_pair(capacity=4096)
        expiry = TokenExpiry(who) if isinstance(who, Principal) else who
        serving = asyncio.ensure_future(serve_application(self.host, far, expiry))
        try:
            yield Wire(near)
        finally:
            await near.close()
            await asyncio.wait({serving}, timeout=PATIENCE)

    def reached(self) -> set[tuple[str, str]]:
        """Return the calls since the last call of this method."""
        found = {call for robot in self.robots.values() for call in robot.reached}
        for robot in self.robots.values():
            robot.reached.clear()
        return found


@asynccontextmanager
async def place(*robots: str | Watched, audit: Audit | None = None) -> AsyncIterator[Place]:
    """Run a gateway with robots; one that is given by its id has all seventeen components."""
    watched = [Watched(robot) if isinstance(robot, str) else robot for robot in robots]
    engine = Engine("gateway")
    for robot in watched:
        await engine.attach(robot)
    async with AsyncExitStack() as stack:
        host = EngineHost(engine, await stack.enter_async_context(TaskScope()), audit=audit or Audit())
        yield Place(host, {robot.robot.engine_id: robot for robot in watched})
