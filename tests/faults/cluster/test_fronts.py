"""F46: a gateway that has applications of engines elsewhere is killed, or stands still."""

import asyncio
import time
from pathlib import Path

import pytest

from tests.support.cluster_site import cluster_site
from tests.support.postgres import Server
from tests.support.seeds import lasting

pytestmark = [pytest.mark.usefixtures("haproxy", "nats"), pytest.mark.timeout(300)]


@pytest.mark.parametrize("seed", lasting())
async def test_f46_a_front_that_is_killed_and_no_other_gets_the_arm(
    seed: int, postgres_server: Server, tmp_path: Path
) -> None:
    async with cluster_site(seed, postgres_server, tmp_path, balance="first") as here:
        gateways = here.cluster.gateways
        await here.adapter("robot", gateways["c"])
        app = await here.operator("app")
        rival = await here.operator("rival", at=gateways["c"], begins=False)
        await app.moves()
        # The application is at the first gateway that is ready: at one of these.
        for front in (gateways["a"], gateways["b"]):
            await here.turns(0.3)
            killed = time.monotonic()
            await front.kill()
            moving = asyncio.ensure_future(app.moves(3))
            while not moving.done():
                assert not await rival.binds()
                await asyncio.sleep(0.02)
            print(f"seed {seed}: operated after {await moving - killed:.2f} s")
            await front.start()
            await front.ready()


@pytest.mark.parametrize("seed", lasting())
async def test_f46_a_front_that_stands_still(seed: int, postgres_server: Server, tmp_path: Path) -> None:
    async with cluster_site(seed, postgres_server, tmp_path, balance="first") as here:
        gateways = here.cluster.gateways
        await here.adapter("robot", gateways["c"])
        await here.operator("app")
        for front in (gateways["a"], gateways["b"]):
            await here.turns(0.3)
            front.freeze()
            await asyncio.sleep(0.3 + 10 * here.chance.random())
            front.thaw()
            await front.ready()
            await here.all_move()
