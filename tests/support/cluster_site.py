"""Gateways as processes, haproxy in front, and adapters and applications around them that write down what they see."""

import asyncio
import random
from collections.abc import AsyncIterator, Mapping, Sequence
from contextlib import AsyncExitStack, asynccontextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from openrois.transport.credentials import NO_CREDENTIALS, Credentials
from tests.support.demo import free_port
from tests.support.gateway_processes import (
    OPENROIS,
    PATIENCE,
    GatewayProcess,
    GatewayProcesses,
    Own,
    gateway_processes,
)
from tests.support.histories import LATE, Completed, History, judge
from tests.support.nats import NatsServer, nats_server
from tests.support.postgres import Server
from tests.support.proxies import ShippedProxy, shipped_proxy
from tests.support.recorded import Operator, RecordedAdapter, operator
from tests.support.ways import Way, WayTo, by_relay

__all__ = ["Site", "cluster_site"]

_SAME: Mapping[str, Sequence[str]] = {}

_NATS = """
ping_interval: "1s"
ping_max: 2
cluster {{ name: "openrois", listen: "127.0.0.1:{port}", no_advertise: true, routes: [{routes}] }}
"""
"""What servers of NATS have that are several."""


@dataclass
class Site:
    """A cluster and what is around it.

    Attributes:
        cluster: its gateways.
        nats: joins them; where there are two servers, that of all but gateway `a`.
        postgres: has what they share.
        front: haproxy.
        chance: of this seed.
        adapters: by their engine ids.
        operators: applications, by name.
        ways: from gateways to `nats` and `store`, and what else is not straight, by both ends.
        history: what adapters and applications saw.
    """

    cluster: GatewayProcesses
    nats: NatsServer
    postgres: Server
    front: ShippedProxy
    chance: random.Random
    stack: AsyncExitStack
    adapters: dict[str, RecordedAdapter] = field(default_factory=dict)
    operators: dict[str, Operator] = field(default_factory=dict)
    ways: dict[tuple[str, str], Way] = field(default_factory=dict)
    history: History = field(default_factory=History)

    async def adapter(
        self, engine_id: str = "robot", *gateways: GatewayProcess | str, credentials: Credentials = NO_CREDENTIALS
    ) -> RecordedAdapter:
        """Let an adapter dial these gateways or addresses, or all, and wait until one has attached it."""
        dialled = gateways or self.cluster.gateways.values()
        urls = [each if isinstance(each, str) else each.adapter_url for each in dialled]
        made = self.adapters[engine_id] = RecordedAdapter(self.history, engine_id)
        await self.stack.enter_async_context(made.serving(urls, credentials))
        async with asyncio.timeout(PATIENCE):
            await made.connected.wait()
        return made

    async def adapter_over_ways(self, engine_id: str) -> RecordedAdapter:
        """Let an adapter dial every gateway over a relay of its own."""
        urls = []
        for each in self.cluster.gateways.values():
            made = await self.stack.enter_async_context(by_relay(each.url.split("/")[2]))
            self.ways[engine_id, each.gateway_id] = made
            urls.append(f"ws://{made.address}/adapter")
        return await self.adapter(engine_id, *urls)

    async def operator(
        self,
        name: str,
        engine_id: str = "robot",
        at: GatewayProcess | str | None = None,
        *,
        begins: bool = True,
        credentials: Credentials = NO_CREDENTIALS,
    ) -> Operator:
        """Let an application operate the arm of an engine through haproxy, or at one gateway or address.

        One that is not to begin anything only connects.
        """
        place = self.front.url if at is None else at if isinstance(at, str) else at.url
        url = place.replace("http", "ws", 1)
        made = operator(self.history, url, name, f"{engine_id}/arm", begins=begins, credentials=credentials)
        app = self.operators[name] = await self.stack.enter_async_context(made)
        return app

    async def crowd(self, count: int = 3) -> None:
        """Let adapters dial gateways by chance, and as many applications operate them through haproxy."""
        for number in range(count):
            await self.adapter(f"robot{number}")
            app = await self.operator(f"app{number}", f"robot{number}")
            app.seconds = self.chance.choice((0.0, 0.02, 0.2))
        await self.all_move()

    async def pair(self) -> tuple[Operator, Operator]:
        """Let an application operate an engine at its own gateway `a`, and one at `b` another engine at `a`."""
        gateways = self.cluster.gateways
        for engine_id in ("near", "far"):
            await self.adapter(engine_id, gateways["a"])
        inside = await self.operator("inside", "near", gateways["a"])
        across = await self.operator("across", "far", gateways["b"])
        await self.all_move()
        return inside, across

    async def all_move(self, more: int = 3) -> float:
        """Wait until every application has moved its arm some times; return since when all of them could."""
        return max(await asyncio.gather(*(each.moves(more) for each in self.operators.values())))

    def ends(self) -> set[str]:
        """Return how commands have ended."""
        return {entry.status for entry in self.history.entries if isinstance(entry, Completed)}

    async def turns(self, seconds: float) -> None:
        """Let some time pass by chance, so that the next thing happens at another moment."""
        await asyncio.sleep(self.chance.random() * seconds)

    def said(self) -> str:
        """What the applications were told at last, for the reader of a failed run."""
        return "\n".join(f"{name}: {each.done} done, {each.refusals[-3:]}" for name, each in self.operators.items())


@asynccontextmanager
async def cluster_site(
    seed: int,
    postgres: Server,
    folder: Path,
    *,
    balance: str = "leastconn",
    weights: Sequence[int] = (),
    may_forget: bool = False,
    late: float = LATE,
    way: WayTo | None = None,
    apart: WayTo | None = None,
    programs: Mapping[str, Sequence[str]] = _SAME,
    **options: Any,
) -> AsyncIterator[Site]:
    """Run three gateways for one seed of a fault; in the end the history is judged.

    Args:
        seed: of all chance.
        postgres: has what they share; its store is emptied.
        folder: for logs.
        balance: of haproxy.
        weights: of the gateways there.
        may_forget: ends of commands may be lost, which their applications are told.
        late: seconds after the end of a command was told in which it may still begin.
        way: makes the way of each gateway to NATS, and to PostgreSQL; None for straight ones.
        apart: makes the way between two servers of NATS, that of gateway `a` and that of the others; None for one.
        programs: run some of the gateways, by id.
        options: of the gateways.
    """
    async with AsyncExitStack() as stack:
        port = free_port()
        nats = stack.enter_context(nats_server(folder, _NATS.format(port=port, routes="") if apart else ""))
        ways: dict[tuple[str, str], Way] = {}
        servers = dict.fromkeys("abc", nats)
        if apart is not None:
            between = ways["a", "others"] = await stack.enter_async_context(apart(f"127.0.0.1:{port}"))
            route = f'"nats-route://{between.address}"'
            servers["a"] = stack.enter_context(nats_server(folder, _NATS.format(port=free_port(), routes=route)))
        if way is not None:
            for gateway_id in "abc":
                for name, target in (("nats", f"127.0.0.1:{servers[gateway_id].port}"), ("store", postgres.socket)):
                    ways[gateway_id, name] = await stack.enter_async_context(way(target))
        own = {each: _own(each, servers[each], ways, postgres, programs.get(each, OPENROIS)) for each in "abc"}
        cluster = await stack.enter_async_context(gateway_processes(nats, postgres, folder, own=own, **options))
        urls = [each.url for each in cluster.gateways.values()]
        front = await stack.enter_async_context(shipped_proxy(*urls, balance=balance, weights=weights))
        around = await stack.enter_async_context(AsyncExitStack())
        here = Site(cluster, nats, postgres, front, random.Random(seed), around, ways=ways)
        try:
            yield here
        except BaseException as error:
            error.add_note(f"seed {seed}\n{here.said()}")
            raise
        await around.aclose()
        wrong = judge(here.history, may_forget=may_forget, late=late)
        assert not wrong, "\n".join((f"seed {seed}", *wrong, here.said(), *here.history.told()))


def _own(
    gateway_id: str,
    server: NatsServer,
    ways: Mapping[tuple[str, str], Way],
    postgres: Server,
    program: Sequence[str],
) -> Own:
    """Return what one gateway has otherwise than the others."""
    nats, store = ways.get((gateway_id, "nats")), ways.get((gateway_id, "store"))
    return Own(
        server.url if nats is None else f"nats://{nats.address}",
        postgres.url if store is None else f"postgresql://openrois@{store.address}/postgres?sslmode=disable",
        tuple(program),
    )
