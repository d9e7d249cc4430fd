"""Ownership on a real server that is killed, stands still, cuts connections, or loses its last commits."""

import asyncio
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import AsyncExitStack, asynccontextmanager
from pathlib import Path

import pytest

from openrois.cluster.postgres.database import Database
from openrois.cluster.postgres.ownership import PostgresStore
from openrois.errors import StoreUnreachable
from openrois.ownership.directorate import Directorate
from openrois.ownership.errors import ClaimRefused
from tests.support.ownership import PATIENT, blocks_overlap, never, until_owned
from tests.support.postgres import Server

pytestmark = pytest.mark.extra(name="cluster")

CUT = "SELECT pg_terminate_backend(pid) FROM pg_stat_activity WHERE application_name LIKE 'openrois%'"
LONG = 600.0
"""Seconds of a time-out that no test reaches."""


async def soon(_seconds: float) -> None:
    """Wait as short as can be before an attempt to connect again."""
    await asyncio.sleep(0.01)


@asynccontextmanager
async def gateway(server: Server, name: str, patience: float = PATIENT) -> AsyncIterator[Directorate]:
    """Run a gateway that renews when it is told to."""
    async with (
        Database(server.url, server.password_file, gateway_id=name, sleep=soon) as database,
        Directorate(PostgresStore(database), name, ttl=LONG, patience=patience, sleep=never) as made,
    ):
        yield made


@pytest.fixture
async def server(postgres_server: Server) -> Server:
    async with postgres_server.admin() as admin:
        await admin.execute("DROP SCHEMA IF EXISTS openrois CASCADE")
    return postgres_server


@pytest.fixture
async def gateways(server: Server) -> AsyncIterator[tuple[Directorate, Directorate]]:
    async with gateway(server, "a") as a, gateway(server, "b") as b:
        yield a, b


async def until_it_works(work: Callable[[], Awaitable[object]]) -> None:
    """Call until the store is there again."""
    async with asyncio.timeout(PATIENT):
        while True:
            try:
                await work()
                return
            except StoreUnreachable:
                await asyncio.sleep(0)


async def test_a_server_that_is_killed_fails_calls_with_a_reason_and_keeps_claims(
    server: Server, gateways: tuple[Directorate, Directorate]
) -> None:
    a, b = gateways
    claim = await a.claim("kachaka", "one")
    server.kill()
    try:
        async with asyncio.timeout(PATIENT):
            for work in (a.renew, lambda: a.claim("reachy", "one"), lambda: b.claim("kachaka", "one")):
                with pytest.raises(StoreUnreachable, match=f"^PostgreSQL {server.data.parent}/postgres: "):
                    await work()
        assert a.problem
        assert await a.claim("kachaka", "one") == claim
    finally:
        server.start()
    await until_it_works(a.renew)
    await until_it_works(b.renew)
    assert a.problem == ""
    assert a.claims.keys() == b.owners.keys() == {"kachaka"}
    with pytest.raises(ClaimRefused):
        await b.claim("kachaka", "two")


async def test_a_server_that_stands_still_fails_calls_in_time_while_adapters_dial_their_owner_again(
    server: Server,
) -> None:
    async with gateway(server, "a", patience=2.0) as a, gateway(server, "b") as b:
        claim = await a.claim("kachaka", "one")
        server.stop()
        try:
            async with asyncio.timeout(PATIENT):
                for work in (lambda: a.claim("reachy", "one"), a.renew, lambda: a.claim("reachy", "one")):
                    with pytest.raises(StoreUnreachable, match=r"did not answer|connection was lost|not connected"):
                        await work()
                    assert (await a.claim("kachaka", "one")).first_epoch == claim.first_epoch
        finally:
            server.go_on()
        await until_it_works(a.renew)
        await until_it_works(b.renew)
        # What was asked meanwhile may have been done when the server went on: then it was undone.
        assert a.claims.keys() == {"kachaka"}
        await until_it_works(lambda: b.claim("reachy", "two"))


async def test_connections_that_are_cut_are_made_again_and_nothing_is_missed(
    server: Server, gateways: tuple[Directorate, Directorate]
) -> None:
    a, b = gateways
    async with server.admin() as admin:
        for number in range(3):
            await admin.execute(CUT)
            engine_id = f"robot-{number}"

            async def claim(engine_id: str = engine_id) -> None:
                await a.claim(engine_id, "one")

            await until_it_works(claim)
            assert await until_owned(b, engine_id, "a")
    await until_it_works(a.renew)
    assert a.claims.keys() == b.owners.keys() == {"robot-0", "robot-1", "robot-2"}


async def test_a_change_without_a_notification_is_seen_by_the_next_renewal(
    server: Server, gateways: tuple[Directorate, Directorate]
) -> None:
    a, b = gateways
    async with server.admin() as admin:
        await admin.execute("ALTER TABLE openrois.claim DISABLE TRIGGER notify_owner")
    claim = await a.claim("kachaka", "one")
    await b.renew()
    assert b.owners["kachaka"].epoch == claim.first_epoch
    await b.claim("kachaka", "one")
    await a.renew()
    assert a.claims == {}


async def test_a_server_set_back_to_an_older_copy_gives_no_block_that_was_used(server: Server, tmp_path: Path) -> None:
    async with AsyncExitStack() as stack:
        a, b, c = [await stack.enter_async_context(gateway(server, name)) for name in "abc"]
        blocks = [await a.claim("kachaka", "one")]
        async with server.admin() as admin:
            await admin.execute("CHECKPOINT")
        server.kill()
        server.copy(server.data, tmp_path / "copy")
        server.start()
        for work in (a.renew, b.renew, c.renew):
            await until_it_works(work)
        blocks.append(await b.claim("kachaka", "one"))
        only_later = await b.claim("reachy", "three")
        server.restart_from(tmp_path / "copy")
        for work in (a.renew, c.renew):
            await until_it_works(work)
        assert "reachy" not in a.owners
        blocks.append(await c.claim("kachaka", "one", above=blocks[-1].first_epoch + 1000))
        await until_it_works(b.renew)
        await until_it_works(a.renew)
        assert not blocks_overlap((each.first_epoch, each.last_epoch) for each in blocks)
        assert a.claims == {}
        assert b.claims == {"reachy": only_later}
        assert a.owners["kachaka"].epoch == blocks[-1].first_epoch


async def test_rows_that_are_deleted_are_written_again_by_their_owner(
    server: Server, gateways: tuple[Directorate, Directorate]
) -> None:
    a, b = gateways
    claim = await a.claim("kachaka", "one")
    async with server.admin() as admin:
        await admin.execute("DELETE FROM openrois.claim; DELETE FROM openrois.gateway")
    await a.renew()
    await b.renew()
    assert a.claims == {"kachaka": claim}
    assert b.owners["kachaka"].epoch == claim.first_epoch
    with pytest.raises(ClaimRefused):
        await b.claim("kachaka", "two")


async def test_what_is_left_of_gateways_that_ended_long_ago_is_removed(server: Server) -> None:
    async with gateway(server, "a"), server.admin() as admin:
        await admin.execute("""
            WITH clock AS (SELECT (extract(epoch FROM clock_timestamp()) * 1000)::bigint AS now)
            INSERT INTO openrois.gateway
            SELECT 'dead', 1, now - 90000000, 10000 FROM clock UNION ALL SELECT 'alive', 1, now, 10000 FROM clock;
            INSERT INTO openrois.claim VALUES ('of the dead', 'dead', 'one', 7), ('of the living', 'alive', 'one', 7),
                ('released', '', '', 7), ('released lately', '', '', 9000000000000);
        """)
        async with gateway(server, "b") as b:
            assert b.owners.keys() == {"of the living"}
        left = {row[0] for row in await admin.fetch("SELECT engine_id FROM openrois.claim")}
        assert left == {"of the living", "released lately"}
        assert await admin.fetchval("SELECT count(*) FROM openrois.gateway WHERE gateway_id = 'dead'") == 0
