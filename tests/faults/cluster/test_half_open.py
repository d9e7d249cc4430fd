"""F50: a way between two parts goes half open, in one direction or both, and goes on after a while or is cut."""

import asyncio
from pathlib import Path

import pytest

from tests.support.cluster_site import Site, cluster_site
from tests.support.gateway_processes import until
from tests.support.postgres import Server
from tests.support.seeds import lasting
from tests.support.ways import Way, by_relay

pytestmark = [pytest.mark.usefixtures("haproxy", "nats"), pytest.mark.timeout(300)]

DIRECTIONS = (
    {"there": True, "back": True},
    {"there": True, "back": False},
    {"there": False, "back": True},
)


async def go_half_open(here: Site, *ways: Way) -> None:
    """Let ways go half open for a while, by chance up to 30 s, and go on or be cut."""
    directions = here.chance.choice(DIRECTIONS)
    seconds = 30.0 if here.chance.random() < 0.1 else 1 + 11 * here.chance.random()
    is_cut = here.chance.random() < 0.5
    print(f"{directions} for {seconds:.1f} s, then {'cut' if is_cut else 'goes on'}")
    for way in ways:
        way.block(**directions)
    await asyncio.sleep(seconds)
    for way in ways:
        if is_cut:
            way.cut()
        way.open()


@pytest.mark.parametrize("seed", lasting())
@pytest.mark.parametrize("name", ["nats", "store"])
async def test_f50_between_a_gateway_and_what_gateways_share(
    seed: int, name: str, postgres_server: Server, tmp_path: Path
) -> None:
    async with cluster_site(seed, postgres_server, tmp_path, way=by_relay) as here:
        inside, across = await here.pair()
        for gateway_id in here.chance.sample("ab", 2):
            await here.turns(0.3)
            across.refusals.clear()
            failing = asyncio.ensure_future(go_half_open(here, here.ways[gateway_id, name]))
            # What a gateway has for its own applications goes on meanwhile.
            await inside.moves(10)
            await failing
            await here.cluster[gateway_id].ready()
            await here.all_move()
            longest = max((seconds for seconds, _ in across.refusals), default=0.0)
            print(f"seed {seed}: {len(across.refusals)} refusals, each in at most {longest:.2f} s")


@pytest.mark.parametrize("seed", lasting())
async def test_f50_between_an_adapter_and_its_gateway(seed: int, postgres_server: Server, tmp_path: Path) -> None:
    async with cluster_site(seed, postgres_server, tmp_path) as here:
        gateways = here.cluster.gateways
        way = await here.stack.enter_async_context(by_relay(gateways["a"].url.split("/")[2]))
        await here.adapter("robot", f"ws://{way.address}/adapter", gateways["b"], gateways["c"])
        await here.operator("inside", at=gateways["a"])
        for _ in range(2):
            await here.turns(0.3)
            await go_half_open(here, way)
            await here.all_move()


@pytest.mark.parametrize("seed", lasting())
async def test_f50_between_an_application_and_its_gateway(seed: int, postgres_server: Server, tmp_path: Path) -> None:
    async with cluster_site(seed, postgres_server, tmp_path) as here:
        gateways = here.cluster.gateways
        way = await here.stack.enter_async_context(by_relay(gateways["b"].url.split("/")[2]))
        await here.adapter("robot", gateways["a"])
        await here.operator("app", at=f"http://{way.address}/")
        for _ in range(2):
            await here.turns(0.3)
            await go_half_open(here, way)
            await here.all_move()


@pytest.mark.parametrize("seed", lasting())
async def test_f50_what_waited_on_the_way_to_an_adapter_does_nothing(
    seed: int, postgres_server: Server, tmp_path: Path
) -> None:
    # The adapter does not know yet that its gateway has given it up when the way goes on.
    async with cluster_site(seed, postgres_server, tmp_path, late=0.0) as here:
        gateways = here.cluster.gateways
        way = await here.stack.enter_async_context(by_relay(gateways["a"].url.split("/")[2]))
        await here.adapter("robot", f"ws://{way.address}/adapter")
        app = await here.operator("inside", at=gateways["a"])

        async def is_refused() -> bool:
            return bool(app.refusals)

        for _ in range(3):
            await here.all_move()
            app.refusals.clear()
            await here.turns(0.3)
            way.block(there=here.chance.random() < 0.5)
            await until(is_refused, "the adapter is not given up")
            way.open()
        await here.all_move()
