"""The schema of the store: made once, migrated forward and back by one; newer by one it is used, else refused."""

import asyncio
from collections.abc import AsyncIterator
from typing import Any

import pytest

from openrois.cluster.postgres.schema import NEWEST, STEPS, VERSION, Step, StoreUnusable, migrate, migrate_back
from tests.support.postgres import Server

pytestmark = pytest.mark.extra(name="cluster")

NEXT = (
    *STEPS,
    Step("ALTER TABLE openrois.claim ADD COLUMN colour text", "ALTER TABLE openrois.claim DROP COLUMN colour"),
)
AFTER_NEXT = (*NEXT, Step("CREATE TABLE openrois.more (number int)", "DROP TABLE openrois.more"))


@pytest.fixture
async def admin(postgres_server: Server) -> AsyncIterator[Any]:
    async with postgres_server.admin() as connection:
        await connection.execute("DROP SCHEMA IF EXISTS openrois CASCADE")
        yield connection


async def columns(admin: Any) -> list[str]:
    rows = await admin.fetch(
        "SELECT table_name || '.' || column_name FROM information_schema.columns WHERE table_schema = 'openrois'"
    )
    return sorted(row[0] for row in rows)


async def test_it_is_made_in_an_empty_database(admin: Any) -> None:
    assert await migrate(admin) == 0
    assert await migrate(admin) == VERSION
    assert "claim.first_epoch" in await columns(admin)


async def test_what_is_in_it_survives_a_migration_and_the_way_back(admin: Any) -> None:
    await migrate(admin)
    before = await columns(admin)
    await admin.execute("INSERT INTO openrois.claim VALUES ('kachaka', 'a', 'one', 7)")
    assert await migrate(admin, NEXT) == VERSION
    assert await columns(admin) == sorted([*before, "claim.colour"])
    assert await migrate_back(admin, NEXT) == VERSION + 1
    assert await columns(admin) == before
    assert await admin.fetchval("SELECT first_epoch FROM openrois.claim") == 7
    assert await migrate(admin) == VERSION


async def test_one_that_is_newer_by_one_version_stays_as_it_is(admin: Any) -> None:
    await migrate(admin, NEXT)
    before = await columns(admin)
    assert await migrate(admin) == NEWEST
    assert await columns(admin) == before
    assert await migrate(admin, NEXT) == NEWEST


async def test_every_version_goes_back_to_the_one_before_it(admin: Any) -> None:
    left = []
    for number in range(len(STEPS) + 1):
        await migrate(admin, STEPS[:number])
        left.append(await columns(admin))
    for number in range(len(STEPS), 0, -1):
        await migrate_back(admin, STEPS[:number])
        assert await columns(admin) == left[number - 1]


async def test_one_that_is_newer_by_two_is_refused(admin: Any) -> None:
    await migrate(admin, AFTER_NEXT)
    for work, why in (
        (migrate, f"works with versions up to {NEWEST}: install a newer one, or run `openrois gateway --migrate-store"),
        (migrate_back, f"goes back from version {VERSION}: run the OpenRoIS that made it"),
    ):
        with pytest.raises(StoreUnusable, match=f"the store has version {NEWEST + 1} of the schema, .*{why}"):
            await work(admin)
    assert await admin.fetchval("SELECT version FROM openrois.version") == NEWEST + 1


async def test_only_the_program_that_made_it_goes_back(admin: Any) -> None:
    await migrate(admin, NEXT)
    with pytest.raises(StoreUnusable, match=f"version {NEWEST} of the schema, and this program goes back from"):
        await migrate_back(admin)
    await migrate_back(admin, NEXT)
    with pytest.raises(StoreUnusable, match=f"version {VERSION} of the schema, and this program goes back from"):
        await migrate_back(admin, NEXT)


async def test_a_step_that_fails_changes_nothing(admin: Any) -> None:
    await migrate(admin)
    before = await columns(admin)
    with pytest.raises(Exception, match="syntax error"):
        await migrate(admin, (*STEPS, Step("CREATE TABLE openrois.more (number int)", ""), Step("CREATE NONSENSE", "")))
    assert await columns(admin) == before


async def test_gateways_that_start_at_once_make_it_once(postgres_server: Server, admin: Any) -> None:
    async def start() -> int:
        async with postgres_server.admin() as connection:
            return await migrate(connection)

    assert sorted(await asyncio.gather(*(start() for _ in range(5)))) == [0, *[VERSION] * 4]


async def test_a_user_that_may_make_nothing_starts_where_it_is_made(admin: Any) -> None:
    await migrate(admin)
    async with admin.transaction():
        await admin.execute(
            "CREATE ROLE of_gateways; GRANT USAGE ON SCHEMA openrois TO of_gateways; "
            "GRANT SELECT, INSERT, UPDATE, DELETE ON ALL TABLES IN SCHEMA openrois TO of_gateways; "
            "SET LOCAL ROLE of_gateways"
        )
        assert await migrate(admin) == VERSION
        await admin.execute("RESET ROLE; DROP OWNED BY of_gateways; DROP ROLE of_gateways")
