"""F47, F48: NATS, which joins the gateways, or PostgreSQL, which they share, is away for a while."""

import asyncio
import shutil
import time
from pathlib import Path

import pytest

from openrois.client import ConnectionLost
from tests.support.cluster_site import cluster_site
from tests.support.histories import Lost
from tests.support.postgres import Server
from tests.support.seeds import SOME, lasting

pytestmark = [pytest.mark.usefixtures("haproxy", "nats"), pytest.mark.timeout(300)]

OUTAGES = [
    *(pytest.param(seed, 3.0, marks=pytest.mark.long) for seed in SOME),
    pytest.param(0, 30.0, marks=pytest.mark.long),
]
"""Seeds, and the seconds that it is away at most: for each of them a few, and once half a minute."""

AT_ONCE = 1.0
"""Seconds in which what cannot be done is refused."""


@pytest.mark.parametrize(("seed", "lasts"), OUTAGES)
@pytest.mark.parametrize("is_killed", [True, False], ids=["killed", "stopped"])
async def test_f47_nats_is_away(
    seed: int, lasts: float, is_killed: bool, postgres_server: Server, tmp_path: Path
) -> None:
    async with cluster_site(seed, postgres_server, tmp_path) as here:
        inside, across = await here.pair()
        await here.turns(0.3)
        (here.nats.kill if is_killed else here.nats.freeze)()
        for each in here.cluster.gateways.values():
            await each.lacks("NATS, which joins the gateways")
        across.refusals.clear()
        await inside.moves(20)
        await asyncio.sleep(lasts - 3 * here.chance.random())
        _, error = across.refusals[-1]
        longest = max(seconds for seconds, _ in across.refusals)
        print(f"seed {seed}: {len(across.refusals)} refusals, each in at most {longest:.3f} s: {error}")
        assert longest < AT_ONCE
        assert not isinstance(error, ConnectionLost | TimeoutError)
        assert "NATS" in str(error)
        done = across.done
        await inside.moves(20)
        assert across.done == done
        back = time.monotonic()
        (here.nats.start if is_killed else here.nats.thaw)()
        for each in here.cluster.gateways.values():
            await each.ready()
        operable = await here.all_move()
        print(f"seed {seed}: operated {operable - back:.2f} s after NATS was back")


@pytest.mark.parametrize(("seed", "lasts"), OUTAGES)
@pytest.mark.parametrize("is_killed", [True, False], ids=["killed", "stopped"])
async def test_f48_postgresql_is_away(
    seed: int, lasts: float, is_killed: bool, postgres_server: Server, tmp_path: Path
) -> None:
    async with cluster_site(seed, postgres_server, tmp_path) as here:
        await here.pair()
        gateways = here.cluster.gateways
        await here.turns(0.3)
        (postgres_server.kill if is_killed else postgres_server.stop)()
        try:
            for each in gateways.values():
                await each.lacks("the store that the gateways share")
            late = asyncio.ensure_future(here.adapter("late", gateways["c"]))
            await here.all_move(20)
            await asyncio.sleep(lasts - 3 * here.chance.random())
            await here.all_move(20)
            assert not late.done()
        finally:
            (postgres_server.start if is_killed else postgres_server.go_on)()
        back = time.monotonic()
        await late
        print(f"seed {seed}: claimed {time.monotonic() - back:.2f} s after PostgreSQL was back")
        for each in gateways.values():
            await each.ready()
        await here.operator("later", "late")
        await here.all_move()


@pytest.mark.parametrize("seed", lasting())
async def test_f48_postgresql_has_lost_its_last_commits(seed: int, postgres_server: Server, tmp_path: Path) -> None:
    # With the last commits the journal has lost ends, and the store tokens that resume sessions.
    async with cluster_site(seed, postgres_server, tmp_path, may_forget=True) as here:
        await here.crowd()
        former = postgres_server.data.with_name("former")
        postgres_server.kill()
        postgres_server.copy(postgres_server.data, former)
        postgres_server.start()
        try:
            for each in here.cluster.gateways.values():
                await each.ready()
            first = await here.cluster.owner("robot0")
            await first.kill()
            await here.all_move()
            second = await here.cluster.owner("robot0", first.gateway_id)
            await here.turns(0.3)
            postgres_server.restart_from(former)
        finally:
            shutil.rmtree(former)
        await here.all_move()
        await second.ready()
        # Where it is lost for good the adapter comes to a gateway that the store knows as another one.
        await first.start()
        await first.ready()
        await here.turns(0.3)
        await second.kill()
        await here.all_move()


@pytest.mark.parametrize("seed", lasting())
async def test_f45_f48_an_owner_is_killed_while_postgresql_is_away(
    seed: int, postgres_server: Server, tmp_path: Path
) -> None:
    async with cluster_site(seed, postgres_server, tmp_path, may_forget=True) as here:
        await here.crowd()
        owner = await here.cluster.owner("robot0")
        postgres_server.kill()
        try:
            await here.turns(0.3)
            await owner.kill()
            await here.turns(12.0)
        finally:
            postgres_server.start()
        await here.all_move()
    lost = sum(isinstance(each, Lost) for each in here.history.entries)
    print(f"seed {seed}: {lost} ends of commands are lost")
