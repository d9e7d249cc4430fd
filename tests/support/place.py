"""Gateways of a cluster, a robot that dials any of them, and applications at each of them."""

import asyncio
from collections.abc import AsyncIterator
from contextlib import AsyncExitStack, asynccontextmanager
from typing import Any

from openrois.adapter.dialer import serve_parent
from openrois.aio.tasks import TaskScope
from openrois.engine.engine import Engine
from openrois.engine.registry import LocalRegistry
from openrois.gateway.server import Gateway
from openrois.session.session import EngineHost
from tests.support.cluster import Cluster, cluster, seen_by
from tests.support.deployment import Adapter, Application, Robot, adapter, application, no_wait, until
from tests.support.nats import NatsServer
from tests.support.postgres import Server

__all__ = ["Place", "owned_by", "place_of", "unit"]


def unit(ref: str, command_type: str, command_id: str = "1", **arguments: str) -> dict[str, Any]:
    """Return a command unit."""
    values = [{"name": name, "data_type_ref": "String", "value": value} for name, value in arguments.items()]
    return {"component_ref": ref, "command_type": command_type, "command_id": command_id, "arguments": values}


class Place:
    """Gateways, a robot at the first one, and applications at any of them."""

    def __init__(self, running: Cluster, robot: Robot, stack: AsyncExitStack) -> None:
        self.cluster = running
        self.robot = robot
        self.stack = stack

    def gateway(self, gateway_id: str) -> Gateway:
        """Return a gateway that runs."""
        return self.cluster.gateways[gateway_id]

    async def app(self, gateway_id: str = "b", **options: Any) -> Application:
        """Connect an application to a gateway, and wait until it sees the robot."""
        app = await self.stack.enter_async_context(application(self.gateway(gateway_id), **options))
        await app.ask("openrois.hello", version="1", extensions=["openrois.lease"])
        await app.ask("rois.system.connect")
        await seen_by(app, "robot")
        return app

    async def attach(self, gateway_id: str, engine_id: str = "robot", robot: Robot | None = None) -> Adapter:
        """Attach an adapter that knows one gateway."""
        parts = robot or self.robot
        at = adapter(self.gateway(gateway_id), *parts.parts(), engine_id=engine_id, extension=parts.streams)
        return await self.stack.enter_async_context(at)

    async def wander(self, *gateway_ids: str, engine_id: str = "robot", **options: Any) -> None:
        """Attach the robot to the first of some gateways, and to the next where that is lost."""
        tasks = await self.stack.enter_async_context(TaskScope())
        engine = Engine(engine_id)
        await engine.attach(LocalRegistry(engine_id, self.robot.parts(), extension=self.robot.streams))
        host = EngineHost(engine, tasks, sleep=no_wait)
        urls = [self.gateway(each).url.replace("http", "ws") + "adapter" for each in gateway_ids]
        # The order is kept where chance is nothing.
        self._host, self._tasks = host, tasks
        self._dialling = tasks.start(serve_parent(host, *urls, chance=lambda: 0.0, **options))

    async def move(self, gateway_id: str) -> None:
        """Let the robot that wanders dial another gateway, as an operator does who sets another address."""
        self._dialling.cancel()
        await asyncio.wait({self._dialling})
        url = self.gateway(gateway_id).url.replace("http", "ws") + "adapter"
        self._dialling = self._tasks.start(serve_parent(self._host, url))


@asynccontextmanager
async def place_of(nats: NatsServer, postgres: Server, *gateway_ids: str, **settings: Any) -> AsyncIterator[Place]:
    """Run gateways and what is around them while the block runs."""
    async with cluster(nats, postgres, *gateway_ids, **settings) as running, AsyncExitStack() as stack:
        yield Place(running, Robot(), stack)


async def owned_by(place: Place, gateway_id: str, engine_id: str = "robot") -> None:
    """Wait until a gateway has the adapter of an engine."""
    await until(place.gateway(gateway_id).engine, lambda engine_ids: engine_id in engine_ids)
