"""F23, F24, F45: a gateway that owns engines is killed, or stands still and goes on."""

import asyncio
import time
from pathlib import Path

import pytest

from tests.support.cluster_site import cluster_site
from tests.support.postgres import Server
from tests.support.seeds import lasting

pytestmark = [pytest.mark.usefixtures("haproxy", "nats"), pytest.mark.timeout(300)]


@pytest.mark.parametrize("seed", lasting(0))
async def test_f45_an_owner_that_is_killed(seed: int, postgres_server: Server, tmp_path: Path) -> None:
    async with cluster_site(seed, postgres_server, tmp_path) as here:
        await here.crowd()
        owner = await here.cluster.owner(here.chance.choice(sorted(here.adapters)))
        owned = [
            each for each in here.adapters.values() if await here.cluster.owner_id(each.engine_id) == owner.gateway_id
        ]
        await here.turns(0.3)
        killed = time.monotonic()
        await owner.kill()
        attached = max([await each.attached(killed) for each in owned])
        operable = await here.all_move()
        print(
            f"seed {seed}: adapters elsewhere after {attached - killed:.2f} s, operated after {operable - killed:.2f} s"
        )
        for each in owned:
            await here.cluster.owner(each.engine_id, owner.gateway_id)
        await owner.start()
        await owner.ready()
        await here.all_move()


@pytest.mark.parametrize("seed", lasting())
async def test_f23_an_owner_that_stands_still_and_goes_on(seed: int, postgres_server: Server, tmp_path: Path) -> None:
    async with cluster_site(seed, postgres_server, tmp_path) as here:
        adapter = await here.adapter()
        owner = await here.cluster.owner("robot")
        # One sends its commands to the gateway that stands still, which reads them when it goes on.
        app = await here.operator("app", at=owner)
        await app.moves()
        await here.turns(0.3)
        stopped = time.monotonic()
        owner.freeze()
        await adapter.attached(stopped)
        latter = await here.cluster.owner("robot", owner.gateway_id)
        rival = await here.operator("rival", at=latter)
        await rival.moves()
        owner.thaw()
        await rival.moves(10)
        await owner.ready()
        print(f"seed {seed}: {len(app.refusals)} refusals of the former holder, the last {app.refusals[-1:]}")
        # It is operable where its owner is now, as soon as the other one leaves it.
        rival.finish()
        await rival.client.release("robot/arm")
        await app.bind()
        await app.moves()


@pytest.mark.parametrize("seed", lasting())
async def test_f45_an_owner_that_stands_still_for_a_while(seed: int, postgres_server: Server, tmp_path: Path) -> None:
    async with cluster_site(seed, postgres_server, tmp_path) as here:
        await here.crowd()
        owner = await here.cluster.owner("robot0")
        for _ in range(2):
            await here.turns(0.3)
            owner.freeze()
            await asyncio.sleep(0.3 + 6 * here.chance.random())
            owner.thaw()
            await owner.ready()
            await here.all_move()
