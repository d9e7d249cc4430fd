"""F51: partitions: gateways are cut off from NATS, PostgreSQL, adapters and each other, in combinations."""

import asyncio
import time
from functools import partial
from pathlib import Path

import pytest

from openrois.client import ConnectionLost
from tests.support.cluster_site import Site, cluster_site
from tests.support.gateway_processes import until
from tests.support.postgres import Server
from tests.support.recorded import Operator
from tests.support.seeds import lasting
from tests.support.ways import Way, WayTo, by_cable, by_relay

pytestmark = [pytest.mark.usefixtures("haproxy", "nats", "namespaces"), pytest.mark.timeout(300)]

over_either = pytest.mark.parametrize("way", [by_relay, by_cable], ids=["relay", "cable"])
"""The ways of gateways to what they share: over relays what is sent meanwhile comes later; a pulled cable loses it."""

AT_ONCE = 1.0
"""Seconds in which what cannot be done is refused."""


async def block(here: Site, *ways: Way) -> None:
    """Block ways in any order, with moments between."""
    for each in here.chance.sample(ways, len(ways)):
        each.block()
        await here.turns(0.5)


async def is_refused(app: Operator) -> bool:
    """Tell whether an application was refused since it was looked at last."""
    return bool(app.refusals)


async def open_again(here: Site, *ways: Way) -> None:
    """Open ways in any order, with moments between; by chance their connections are reset before."""
    is_cut = here.chance.random() < 0.5
    for each in here.chance.sample(ways, len(ways)):
        if is_cut:
            each.cut()
        each.open()
        await here.turns(0.5)


@over_either
@pytest.mark.parametrize("seed", lasting())
async def test_f51_an_owner_cut_off_from_all_that_gateways_share(
    seed: int, way: WayTo, postgres_server: Server, tmp_path: Path
) -> None:
    async with cluster_site(seed, postgres_server, tmp_path, way=way) as here:
        inside, across = await here.pair()
        await here.turns(0.3)
        cut = here.ways["a", "nats"], here.ways["a", "store"]
        await block(here, *cut)
        await here.cluster["a"].lacks("NATS, which joins the gateways")
        await here.cluster["a"].lacks("the store that the gateways share")
        done = across.done
        # By its store's clock its claims expire meanwhile, by chance.
        await asyncio.sleep(14 * here.chance.random())
        # Its adapters go on with it, for its own applications.
        await inside.moves(10)
        _, error = across.refusals[-1]
        print(f"seed {seed}: {len(across.refusals)} refusals, the last: {error}")
        assert across.done == done
        assert not isinstance(error, ConnectionLost | TimeoutError)
        assert await here.cluster.owner_id("far") == "a"
        await open_again(here, *cut)
        ready = await here.cluster["a"].ready()
        await here.all_move()
        print(f"seed {seed}: ready {ready:.1f} s after that")


@over_either
@pytest.mark.parametrize("seed", lasting())
async def test_f51_an_adapter_leaves_an_owner_that_is_cut_off(
    seed: int, way: WayTo, postgres_server: Server, tmp_path: Path
) -> None:
    async with cluster_site(seed, postgres_server, tmp_path, way=way) as here:
        await here.adapter_over_ways("robot")
        owner = await here.cluster.owner("robot")
        app = await here.operator("app", at=owner)
        await app.moves()
        shared = here.chance.choice((("nats",), ("nats", "store")))
        near = owner.gateway_id
        cut = *(here.ways[near, each] for each in shared), here.ways["robot", near]
        began = time.monotonic()
        await block(here, *cut)
        attached = await here.adapters["robot"].attached(began)
        latter = await here.cluster.owner("robot", near)
        # Its former owner lives, and has the application that held the arm.
        rival = await here.operator("rival", at=latter)
        await rival.moves()
        print(f"seed {seed}: {near} cut off from {shared}; at {latter.gateway_id} after {attached - began:.1f} s")
        await open_again(here, *cut)
        await rival.moves(10)
        await owner.ready()
        rival.finish()
        await rival.client.release("robot/arm")
        await app.bind()
        await app.moves()


@pytest.mark.parametrize("seed", lasting())
async def test_f51_an_adapter_leaves_an_owner_without_a_store(
    seed: int, postgres_server: Server, tmp_path: Path
) -> None:
    # The former owner is not told that it has lost the engine; the application at it goes on with what it holds.
    async with cluster_site(seed, postgres_server, tmp_path, way=by_relay) as here:
        await here.adapter_over_ways("robot")
        owner = await here.cluster.owner("robot")
        near = owner.gateway_id
        inside = await here.operator("inside", at=owner)
        await inside.moves()
        cut = here.ways[near, "store"], here.ways["robot", near]
        began = time.monotonic()
        await block(here, *cut)
        attached = await here.adapters["robot"].attached(began)
        latter = await here.cluster.owner("robot", near)
        print(f"seed {seed}: {near} has lost the store; at {latter.gateway_id} after {attached - began:.1f} s")
        moved = await inside.moves(3)
        print(f"seed {seed}: operated over the former owner after {moved - began:.1f} s")
        await open_again(here, *cut)
        await owner.ready()
        await inside.moves(10)


@pytest.mark.parametrize("seed", lasting())
async def test_f51_one_gateway_without_the_store_and_one_without_nats(
    seed: int, postgres_server: Server, tmp_path: Path
) -> None:
    async with cluster_site(seed, postgres_server, tmp_path, way=by_relay) as here:
        gateways = here.cluster.gateways
        for each in "abc":
            await here.adapter(f"robot-{each}", gateways[each])
            await here.adapter(f"other-{each}", gateways[each])
            await here.operator(f"inside-{each}", f"robot-{each}", gateways[each])
        for owner, front in ("ac", "bc", "cb"):
            await here.operator(f"{front}-at-{owner}", f"other-{owner}", gateways[front])
        await here.all_move()
        cut = here.ways["a", "store"], here.ways["b", "nats"]
        await block(here, *cut)
        await gateways["a"].lacks("the store that the gateways share")
        await gateways["b"].lacks("NATS, which joins the gateways")
        late = asyncio.ensure_future(here.adapter("late", gateways["a"]))
        await here.adapter("later", gateways["b"])
        await here.turns(14)
        goes_on = [here.operators[each] for each in ("inside-a", "inside-b", "inside-c", "c-at-a")]
        await asyncio.gather(*(each.moves(10) for each in goes_on))
        rests = [here.operators[each] for each in ("c-at-b", "b-at-c")]
        done = [each.done for each in rests]
        await goes_on[0].moves(10)
        assert [each.done for each in rests] == done
        assert await here.cluster.owner_id("late") == ""
        await open_again(here, *cut)
        await late
        for gateway in gateways.values():
            await gateway.ready()
        await here.operator("late", "late")
        await here.operator("later", "later")
        await here.all_move()


@pytest.mark.parametrize("seed", lasting())
async def test_f51_gateways_that_do_not_hear_each_other(seed: int, postgres_server: Server, tmp_path: Path) -> None:
    # Each has a server of NATS; the way between these is cut.
    async with cluster_site(seed, postgres_server, tmp_path, apart=by_relay) as here:
        gateways = here.cluster.gateways
        inside, across = await here.pair()
        await here.adapter("other", gateways["b"])
        back = await here.operator("back", "other", gateways["a"])
        for _ in range(2):
            await here.turns(0.3)
            across.refusals.clear()
            await block(here, here.ways["a", "others"])
            await here.turns(12)
            await until(partial(is_refused, across), "an application goes on past the cut")
            await inside.moves(20)
            done = across.done, back.done
            await inside.moves(20)
            assert (across.done, back.done) == done
            seconds, error = across.refusals[-1]
            print(f"seed {seed}: {len(across.refusals)} refusals, the last after {seconds:.3f} s: {error}")
            assert seconds < AT_ONCE
            assert "far belongs to gateway a, which is not reached" in str(error)
            # No claim of a gateway that is there is touched.
            assert await here.cluster.owner_id("far") == "a"
            await open_again(here, here.ways["a", "others"])
            await here.all_move()


@over_either
@pytest.mark.parametrize("seed", lasting())
async def test_f51_partitions_by_chance(seed: int, way: WayTo, postgres_server: Server, tmp_path: Path) -> None:
    # A front gives its owner up after a second, and the owner its adapter after 4.5: what was sent to that may run.
    async with cluster_site(seed, postgres_server, tmp_path, way=way, late=4.5) as here:
        for number in range(2):
            await here.adapter_over_ways(f"robot{number}")
        for number, gateway in enumerate(here.chance.sample("abc", 2)):
            await here.operator(f"app{number}", f"robot{number}", here.cluster[gateway])
        await here.all_move()
        for _ in range(3):
            cut = here.chance.sample(sorted(here.ways), here.chance.randrange(1, len(here.ways)))
            ways = [here.ways[each] for each in cut]
            await block(here, *ways)
            await here.turns(12)
            await open_again(here, *ways)
            for each in here.cluster.gateways.values():
                await each.ready()
            await here.all_move()
            print(f"seed {seed}: {', '.join(' - '.join(each) for each in cut)}")
