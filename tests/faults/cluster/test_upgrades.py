"""F55 to F58: gateways of two minor versions, tables that go on and back, a canary, an upgrade under load."""

import asyncio
import random
import signal
from contextlib import nullcontext
from pathlib import Path

import pytest

from openrois.cluster.postgres.schema import NEWEST, VERSION
from openrois.version import __version__
from tests.support.cluster_site import Site, cluster_site
from tests.support.gateway_processes import OPENROIS, GatewayProcess, until
from tests.support.newer import speaking_newer
from tests.support.next_minor import NEXT_MINOR, NEXT_VERSION, WRITER
from tests.support.postgres import Server
from tests.support.seeds import lasting

pytestmark = [pytest.mark.usefixtures("haproxy", "nats"), pytest.mark.timeout(300)]

CANARY = 2
"""The number of the gateway with the smallest share at haproxy."""


async def version_of_tables(postgres: Server) -> int:
    async with postgres.admin() as admin:
        return int(await admin.fetchval("SELECT version FROM openrois.version"))


async def writers(postgres: Server) -> dict[str, str | None]:
    """Return the version that wrote each claim, by its gateway; None for this one."""
    async with postgres.admin() as admin:
        rows = await admin.fetch(f"SELECT gateway_id, {WRITER} FROM openrois.claim WHERE gateway_id <> ''")
    return dict(map(tuple, rows))


@pytest.mark.parametrize("seed", lasting())
async def test_f55_gateways_and_adapters_of_two_minor_versions(
    seed: int, postgres_server: Server, tmp_path: Path
) -> None:
    chance = random.Random(seed)
    newer = chance.sample("abc", chance.choice((1, 2)))
    adapters = speaking_newer() if seed % 2 else nullcontext()
    programs = dict.fromkeys(newer, NEXT_MINOR)
    with adapters:
        async with cluster_site(seed, postgres_server, tmp_path, programs=programs) as here:
            await here.crowd()
            _, across = await here.pair()
            told = await writers(postgres_server)
            assert told == {each: NEXT_VERSION if each in newer else None for each in told}
            # STOP reaches an owner of the other version, and says what has stopped there.
            assert await across.client.control.stop_all("far") == ("far/arm",)
            await here.all_move()
            for gateway in here.chance.sample(list(here.cluster.gateways.values()), 3):
                await gateway.restart()
                await here.all_move()
            said = here.cluster.said()
            assert f"runs OpenRoIS {NEXT_VERSION}, and this one is {__version__}" in said
            assert f"runs OpenRoIS {__version__}, and this one is {NEXT_VERSION}" in said
            assert "is of an older version" not in said


@pytest.mark.parametrize("seed", lasting())
async def test_f56_tables_go_on_by_one_version_and_back_while_gateways_work(
    seed: int, postgres_server: Server, tmp_path: Path
) -> None:
    async with cluster_site(seed, postgres_server, tmp_path) as here:
        await here.crowd()
        newer, *others = here.chance.sample(list(here.cluster.gateways.values()), 3)
        await newer.restart(NEXT_MINOR)
        assert await version_of_tables(postgres_server) == NEWEST
        await here.all_move()
        for each in others:
            await each.restart()
            await here.all_move()
        assert await version_of_tables(postgres_server) == NEWEST
        status, said = await others[0].run("--migrate-store-back")
        assert (status, f"goes back from version {VERSION}: run the OpenRoIS that made it" in said) == (1, True)
        newer.signal(signal.SIGTERM)
        assert await newer.ended() == 0
        await here.all_move()
        status, said = await newer.run("--migrate-store-back")
        assert (status, await version_of_tables(postgres_server)) == (0, VERSION), said
        await here.all_move()
        newer.program = OPENROIS
        await newer.start()
        await newer.ready()
        await here.all_move()
        assert await version_of_tables(postgres_server) == VERSION
        assert here.ends() == {"OK"}


async def canary_site(here: Site) -> GatewayProcess:
    """Let five applications come through haproxy, whose bodies the other gateways own; return the canary."""
    a, b, canary = here.cluster.gateways.values()
    for number in range(5):
        await here.adapter(f"robot{number}", a, b)
        app = await here.operator(f"app{number}", f"robot{number}")
        app.seconds = here.chance.choice((0.0, 0.02, 0.2))
    await here.all_move()
    assert await here.front.connections() == [2, 2, 1]
    return canary


async def moved_away(here: Site) -> None:
    """Wait until applications are at the other gateways alone."""

    async def are_away() -> bool:
        *others, at_canary = await here.front.connections()
        return at_canary == 0 and sum(others) == len(here.operators)

    await until(are_away, "an application is at the canary")
    await asyncio.gather(*(here.operators[f"app{number}"].moves() for number in range(5)))


@pytest.mark.parametrize("seed", lasting())
async def test_f57_a_canary_takes_its_share_and_nothing_is_lost_when_it_is_killed(
    seed: int, postgres_server: Server, tmp_path: Path
) -> None:
    programs = {"c": NEXT_MINOR}
    async with cluster_site(seed, postgres_server, tmp_path, weights=(2, 2, 1), programs=programs) as here:
        canary = await canary_site(here)
        await here.turns(0.5)
        await canary.kill()
        await moved_away(here)
        assert here.ends() == {"OK"}


@pytest.mark.parametrize("seed", lasting())
async def test_f57_a_canary_is_drained_away(seed: int, postgres_server: Server, tmp_path: Path) -> None:
    programs = {"c": NEXT_MINOR}
    async with cluster_site(seed, postgres_server, tmp_path, weights=(2, 2, 1), programs=programs) as here:
        canary = await canary_site(here)
        await here.front.set_weight(CANARY, 0)
        # It keeps what it has, and gets no more.
        for number in range(3):
            await here.operator(f"watcher{number}", begins=False)
        *others, at_canary = await here.front.connections()
        assert (sorted(others), at_canary) == ([3, 4], 1)
        await here.turns(0.5)
        canary.signal(signal.SIGTERM)
        assert await canary.ended() == 0
        await moved_away(here)
        await canary.start()
        await canary.ready()
        await here.front.set_weight(CANARY, 8)

        async def has_some() -> bool:
            await here.operator(f"watcher{len(here.operators)}", begins=False)
            return (await here.front.connections())[CANARY] > 0

        await until(has_some, "no application comes to the canary")
        assert here.ends() == {"OK"}


@pytest.mark.parametrize("seed", lasting())
async def test_f58_an_upgrade_under_load_and_its_rollback_lose_no_command(
    seed: int, postgres_server: Server, tmp_path: Path
) -> None:
    async with cluster_site(seed, postgres_server, tmp_path) as here:
        await here.crowd()
        for program in (NEXT_MINOR, OPENROIS):
            for gateway in here.chance.sample(list(here.cluster.gateways.values()), 3):
                await here.turns(0.5)
                await gateway.restart(program)
                await here.all_move()
        assert await version_of_tables(postgres_server) == NEWEST
        assert here.ends() == {"OK"}
