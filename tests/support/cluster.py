"""Gateways of one cluster in this process, with real NATS and PostgreSQL between them."""

import asyncio
from collections.abc import AsyncIterator, Callable, Mapping
from contextlib import AbstractAsyncContextManager, AsyncExitStack, asynccontextmanager
from dataclasses import dataclass, field, fields
from typing import Any

from openrois.gateway.server import Gateway, run_gateway
from openrois.gateway.settings import GatewaySettings
from openrois.gateway.socket import SocketProfile
from tests.support.deployment import PATIENCE, Across, Application
from tests.support.nats import NatsServer, cluster_name, patient_links
from tests.support.postgres import Server

__all__ = ["Cluster", "cluster", "pairs", "seen_by"]

_PLAIN: Mapping[str, SocketProfile] = {}


@dataclass
class Cluster:
    """Gateways that run, by id.

    Attributes:
        nats: joins them.
        postgres: has what they share.
        name: tells the cluster from others at the same NATS.
        gateways: those that run.
    """

    nats: NatsServer
    postgres: Server
    name: str = field(default_factory=cluster_name)
    gateways: dict[str, Gateway] = field(default_factory=dict)
    _stacks: dict[str, AsyncExitStack] = field(default_factory=dict)

    def settings(self, gateway_id: str, **more: Any) -> GatewaySettings:
        """Return the settings of one gateway."""
        return GatewaySettings(
            port=0,
            gateway_id=gateway_id,
            cluster=(self.nats.url,),
            cluster_name=self.name,
            store=self.postgres.url,
            store_password=self.postgres.password_file,
            **more,
        )

    async def start(self, gateway_id: str, profiles: Mapping[str, SocketProfile] = _PLAIN, **more: Any) -> Gateway:
        """Run one more gateway."""
        stack = AsyncExitStack()
        gateway = await stack.enter_async_context(run_gateway(self.settings(gateway_id, **more), **profiles))
        self.gateways[gateway_id], self._stacks[gateway_id] = gateway, stack
        return gateway

    async def stop(self, gateway_id: str) -> None:
        """End a gateway."""
        del self.gateways[gateway_id]
        await self._stacks.pop(gateway_id).aclose()


@asynccontextmanager
async def cluster(nats: NatsServer, postgres: Server, *gateway_ids: str, **more: Any) -> AsyncIterator[Cluster]:
    """Run gateways with a cluster and an empty store of their own while the block runs."""
    async with postgres.admin() as admin:
        await admin.execute("DROP SCHEMA IF EXISTS openrois CASCADE")
    running = Cluster(nats, postgres)
    with patient_links():
        try:
            for gateway_id in gateway_ids:
                await running.start(gateway_id, **more)
            yield running
        finally:
            for gateway_id in tuple(running.gateways):
                await running.stop(gateway_id)


async def seen_by(application: Application, *engine_ids: str, absent: bool = False) -> None:
    """Wait until an application sees engines, or does not see any of them more."""
    async with asyncio.timeout(PATIENCE):
        while True:
            answer = await application.ask("rois.system.get_profile", condition="")
            found = {each["identifier"]["code"] for each in answer["profile"]["sub_profiles"]}
            if not found & set(engine_ids) if absent else found >= set(engine_ids):
                return
            await application.next("rois.system.profile_changed")


def pairs(nats: NatsServer, postgres: Server) -> Callable[..., AbstractAsyncContextManager[Across]]:
    """Return what makes the gateways of a test where it has two of them: one for applications, one for adapters."""

    @asynccontextmanager
    async def pair(application: SocketProfile, adapter: SocketProfile, **settings: Any) -> AsyncIterator[Across]:
        profiles = {"application": application, "adapter": adapter}
        async with cluster(nats, postgres) as both:
            owner = await both.start("a", profiles, **settings)
            front = await both.start("b", profiles, **settings)
            assert front.federation is not None
            same = {each.name: getattr(front, each.name) for each in fields(Gateway)} | {"engine": owner.engine}
            yield Across(**same, adapters=owner.url, seen=front.federation.directory)

    return pair
