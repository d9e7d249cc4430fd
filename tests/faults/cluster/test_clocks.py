"""F52: the wall clocks of gateways, and that of PostgreSQL, differ by an hour."""

import signal
import time
from collections.abc import Iterator
from datetime import datetime
from pathlib import Path

import pytest

from openrois.client import ConnectionFailed
from openrois.transport.credentials import Credentials
from tests.support.clocks import HOUR, program_at
from tests.support.cluster_site import Site, cluster_site
from tests.support.gateway_processes import OPENROIS, GatewayProcess
from tests.support.histories import Completed
from tests.support.postgres import Server
from tests.support.seeds import lasting
from tests.support.tokens import issue, key_file

pytestmark = [pytest.mark.usefixtures("haproxy", "nats", "faketime"), pytest.mark.timeout(300)]

AHEAD = {"a": HOUR, "b": -HOUR, "c": 0.0}
"""Seconds by which the wall clock of each gateway is ahead."""

PROGRAMS = {gateway_id: program_at(ahead, *OPENROIS) for gateway_id, ahead in AHEAD.items() if ahead}


@pytest.fixture
def store(postgres_server: Server) -> Iterator[Server]:
    """PostgreSQL, whose clock is right in the end."""
    yield postgres_server
    if postgres_server.ahead:
        postgres_server.set_clock(0.0)


def clock_of(gateway: GatewayProcess) -> float:
    """Return by how many seconds the clock of a gateway is ahead that has just started, by its last line."""
    last = next(line.split()[0] for line in reversed(gateway.said().splitlines()) if line.startswith("20"))
    return datetime.fromisoformat(last).timestamp() - time.time()


async def epochs(here: Site) -> dict[str, int]:
    """Return the first epoch of each engine's claim."""
    async with here.postgres.admin() as admin:
        return dict(await admin.fetch("SELECT engine_id, first_epoch FROM openrois.claim"))


async def every_owner_goes(here: Site) -> None:
    """Kill each gateway in turn, or stop it in good order; the gateway that has its engines then has greater epochs."""
    for gateway in here.chance.sample(list(here.cluster.gateways.values()), 3):
        before = await epochs(here)
        owned = [each for each in here.adapters if await here.cluster.owner_id(each) == gateway.gateway_id]
        await here.turns(0.3)
        if here.chance.random() < 0.5:
            await gateway.kill()
        else:
            gateway.signal(signal.SIGTERM)
            assert await gateway.ended() == 0
        for each in owned:
            await here.cluster.owner(each, gateway.gateway_id)
        await here.all_move()
        after = await epochs(here)
        assert all(after[each] >= before[each] + 1_000_000 for each in owned)
        await gateway.start()
        await gateway.ready()
        await here.all_move()


@pytest.mark.parametrize("seed", lasting())
async def test_f52_gateways_whose_clocks_are_an_hour_apart(seed: int, store: Server, tmp_path: Path) -> None:
    async with cluster_site(seed, store, tmp_path, programs=PROGRAMS) as here:
        assert {each: round(clock_of(here.cluster[each]), -2) for each in "abc"} == AHEAD
        await here.crowd()
        await every_owner_goes(here)


@pytest.mark.parametrize("ahead", [HOUR, -HOUR], ids=["ahead", "behind"])
@pytest.mark.parametrize("seed", lasting())
async def test_f52_the_clock_of_postgresql_is_set(seed: int, ahead: float, store: Server, tmp_path: Path) -> None:
    async with cluster_site(seed, store, tmp_path, programs=PROGRAMS) as here:
        await here.crowd()
        for offset in (ahead, 0.0):
            await here.turns(0.3)
            store.set_clock(offset)
            async with store.admin() as admin:
                seconds = float(await admin.fetchval("SELECT extract(epoch FROM clock_timestamp())"))
            assert round(seconds - time.time(), -2) == offset
            await here.all_move()
            for each in here.cluster.gateways.values():
                await each.ready()
            await every_owner_goes(here)


def token(ahead: float = 0.0, **claims: object) -> Credentials:
    """Return a token of an issuer whose clock is so many seconds ahead; it is good for a quarter of an hour."""
    return Credentials(issue(time.time() + ahead, scope=["*"], **claims))


@pytest.mark.parametrize("seed", lasting())
async def test_f52_the_clock_of_its_own_gateway_judges_a_token(seed: int, store: Server, tmp_path: Path) -> None:
    options = ("--auth-key", str(key_file(tmp_path)))
    async with cluster_site(seed, store, tmp_path, programs=PROGRAMS, options=options) as here:
        gateways = here.cluster.gateways
        for each, ahead in AHEAD.items():
            await here.adapter(f"robot-{each}", gateways[each], credentials=token(ahead, roles=["adapter"]))
        # At each gateway an application with a token by its clock operates engines of gateways with other clocks.
        for front, owner in ("ab", "bc", "ca"):
            name = f"{front}-at-{owner}"
            await here.operator(name, f"robot-{owner}", gateways[front], credentials=token(AHEAD[front], sub=name))
        # Tokens are looked at every second.
        for app in here.operators.values():
            app.seconds = 0.2
            # Until its owner has told what it offers an engine is not to be had.
            app.refusals.clear()
        await here.all_move(20)
        # A token whose issuer's clock is further off than the leeway is good for nothing.
        for each, off in (("a", -HOUR), ("b", HOUR), ("c", HOUR), ("c", -HOUR)):
            with pytest.raises(ConnectionFailed, match="401"):
                await here.operator("stranger", "robot-a", gateways[each], credentials=token(AHEAD[each] + off))
        await here.all_move(3)
        assert not [each.refusals for each in here.operators.values() if each.refusals]
    assert {entry.status for entry in here.history.entries if isinstance(entry, Completed)} == {"OK"}
