"""A gateway's part in its cluster, without NATS and PostgreSQL."""

from types import SimpleNamespace
from typing import Any, cast

from openrois.aio.tasks import TaskScope
from openrois.engine.engine import Engine
from openrois.engine.registry import LocalRegistry
from openrois.errors import StoreUnreachable
from openrois.gateway.clustering import LOOK_AGAIN, Clustering, ClusterParts
from openrois.leases.epochs import ClaimedEpochs
from openrois.resumption.lines import Holding
from openrois.session.session import ApplicationSession, EngineHost
from tests.support.components import Lamp


async def test_former_holders_are_looked_for_until_the_store_answers() -> None:
    slept = list[float]()

    async def sleep(seconds: float) -> None:
        slept.append(seconds)

    async def held(_engine_ids: object) -> tuple[Holding, ...]:
        if len(slept) < 3:
            raise StoreUnreachable("it is away")
        return (Holding("robot/lamp", "robot", "line", 7, "ann"),)

    async with TaskScope() as tasks:
        engine, epochs = Engine("gateway"), ClaimedEpochs()
        epochs.grant("robot", 10, 20)
        await engine.attach(LocalRegistry("robot", [Lamp()]))
        host = EngineHost(engine, tasks, sleep=sleep, epochs=epochs)
        store = SimpleNamespace(held=held, name="the store")
        directorate = SimpleNamespace(owners={})
        parts = ClusterParts(*cast(Any, (SimpleNamespace(gateway_id="a"), directorate, None, store, None, epochs)))
        clustering = Clustering(parts, host)
        await clustering._look_for_holders(["robot"])
        await clustering._look_again(["robot"])
        assert slept[:3] == [LOOK_AGAIN] * 3
        other = ApplicationSession(host, lambda _method, _params, **_more: None)
        assert host.leases.is_held_by_another("robot/lamp", other)
