"""Lines and holdings on a real server that stands still, is killed, or has lost its last commits."""

import asyncio
from collections.abc import AsyncIterator, Awaitable, Callable

import pytest

from openrois.cluster.postgres.database import Database
from openrois.cluster.postgres.resumption import PostgresResumeStore
from openrois.errors import StoreUnreachable
from openrois.resumption.holdings_writer import HoldingsWriter
from openrois.resumption.lines import Held, Redemption
from tests.support.ownership import PATIENT
from tests.support.postgres import Server

pytestmark = pytest.mark.extra(name="cluster")


async def soon(_seconds: float) -> None:
    """Wait as short as can be before another attempt."""
    await asyncio.sleep(0.01)


@pytest.fixture
async def database(postgres_server: Server) -> AsyncIterator[Database]:
    async with postgres_server.admin() as admin:
        await admin.execute("DROP SCHEMA IF EXISTS openrois CASCADE")
    async with Database(postgres_server.url, postgres_server.password_file, sleep=soon) as made:
        yield made


async def until_it_works(work: Callable[[], Awaitable[object]]) -> None:
    """Call until the store is there again."""
    async with asyncio.timeout(PATIENT):
        while True:
            try:
                await work()
                return
            except StoreUnreachable:
                await asyncio.sleep(0)


async def test_a_call_ends_in_time_where_the_server_stands_still(postgres_server: Server, database: Database) -> None:
    store = PostgresResumeStore(database)
    patient = PostgresResumeStore(database, patience=PATIENT)
    assert await patient.issue("line", 0, "ann", b"one")
    postgres_server.stop()
    try:
        began = asyncio.get_running_loop().time()
        calls = [
            *(store.redeem(b"other", "ann") for _ in range(20)),
            *(store.issue(str(number), 0, "ann", bytes([number])) for number in range(20)),
            *(store.write([Held("robot/lamp", "robot", "line", 7)]), store.held(["robot"])),
            *(store.touch(["line"]), store.end_line("other", 0)),
        ]
        found = await asyncio.gather(*calls, return_exceptions=True)
        assert asyncio.get_running_loop().time() - began < PATIENT / 2
        assert {type(each) for each in found} == {StoreUnreachable}
        assert str(found[0]) == f"{database.name} did not answer within 1 s"
    finally:
        postgres_server.go_on()

    async def redeem() -> None:
        assert await patient.redeem(b"one", "ann") == Redemption("line", 1)

    await until_it_works(redeem)


async def test_changes_that_were_noted_while_the_server_was_dead_are_written(
    postgres_server: Server, database: Database
) -> None:
    store = PostgresResumeStore(database, patience=PATIENT)
    await store.issue("line", 0, "ann", b"one")
    has_failed = asyncio.Event()

    async def sleep(seconds: float) -> None:
        has_failed.set()
        await soon(seconds)

    async with HoldingsWriter(store, sleep=sleep) as writer:
        postgres_server.kill()
        try:
            for epoch in range(1, 4):
                writer.note(Held("robot/lamp", "robot", "line", epoch))
            async with asyncio.timeout(PATIENT):
                await has_failed.wait()
            assert writer.problem
        finally:
            postgres_server.start()
        assert await writer.flushed(PATIENT)
    (held,) = await store.held(["robot"])
    assert held.epoch == 3
