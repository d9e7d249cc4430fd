"""`openrois gateway` where what the gateways of a cluster share cannot be used: it does not start, and says why."""

import asyncio
from pathlib import Path

import pytest

from openrois.cluster.postgres.database import Database
from openrois.cluster.postgres.schema import VERSION
from openrois.gateway.command import main
from tests.support.postgres import Server

pytestmark = pytest.mark.extra(name="cluster")

CLUSTER = ("--port", "0", "--gateway-id", "a", "--cluster", "nats://127.0.0.1:1")


def test_a_store_that_is_not_there_is_one_line(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    store = f"postgresql://openrois@/postgres?host={tmp_path}"
    assert main([*CLUSTER, "--store", store]) == 1
    said = capfd.readouterr().err
    assert said.startswith(f"openrois gateway: PostgreSQL {tmp_path}/postgres")
    assert said.count("\n") == 1


async def set_version(server: Server, statement: str) -> None:
    async with server.admin() as admin:
        await admin.execute(statement)


def test_a_store_that_is_newer_is_one_line(postgres_server: Server, capfd: pytest.CaptureFixture[str]) -> None:
    make = "DROP SCHEMA IF EXISTS openrois CASCADE; CREATE SCHEMA openrois; CREATE TABLE openrois.version (version int)"
    asyncio.run(set_version(postgres_server, f"{make}; INSERT INTO openrois.version VALUES (99)"))
    try:
        store = ("--store", postgres_server.url, "--store-password", str(postgres_server.password_file))
        assert main([*CLUSTER, *store]) == 1
    finally:
        asyncio.run(set_version(postgres_server, "DROP SCHEMA openrois CASCADE"))
    said = capfd.readouterr().err
    assert said.startswith("openrois gateway: the store has version 99 of the schema")
    assert said.count("\n") == 1


def test_the_store_goes_back_by_one_version_and_nothing_starts(
    postgres_server: Server, capfd: pytest.CaptureFixture[str]
) -> None:
    asyncio.run(set_version(postgres_server, "DROP SCHEMA IF EXISTS openrois CASCADE"))
    store = ("--store", postgres_server.url, "--store-password", str(postgres_server.password_file))
    back = [*CLUSTER, *store, "--migrate-store-back"]
    assert main(back) == 1
    assert "the store has version 0 of the schema, and this program goes back from" in capfd.readouterr().err

    async def make() -> None:
        async with Database(postgres_server.url, postgres_server.password_file):
            pass

    asyncio.run(make())
    assert main(back) == 0
    assert capfd.readouterr().out == (
        f"the tables of the store had version {VERSION}, and have version {VERSION - 1} now\n"
    )
    asyncio.run(set_version(postgres_server, "DROP SCHEMA openrois CASCADE"))


def test_without_a_store_nothing_goes_back(capfd: pytest.CaptureFixture[str]) -> None:
    assert main(["--migrate-store-back"]) == 1
    assert capfd.readouterr().err == (
        "openrois gateway: --migrate-store-back needs --store and --cluster, as the gateways have them\n"
    )
