"""Connections to PostgreSQL: with passwords in files, over TLS, and made again when they are cut."""

import asyncio
import logging
import shutil
from collections.abc import AsyncIterator
from pathlib import Path

import pytest

from openrois.cluster.postgres.database import CONNECTIONS, Database
from openrois.cluster.postgres.schema import STEPS, Step, StoreUnusable, migrate
from openrois.errors import StoreUnreachable
from tests.support.certificates import Authority
from tests.support.demo import free_port
from tests.support.ownership import PATIENT
from tests.support.postgres import PASSWORD, Server

pytestmark = pytest.mark.extra(name="cluster")

CUT = "SELECT pg_terminate_backend(pid) FROM pg_stat_activity WHERE application_name LIKE 'openrois%'"


async def soon(_seconds: float) -> None:
    """Wait as short as can be before an attempt to connect again."""
    await asyncio.sleep(0.01)


@pytest.fixture
async def database(postgres_server: Server) -> AsyncIterator[Database]:
    async with Database(postgres_server.url, postgres_server.password_file, gateway_id="a", sleep=soon) as made:
        yield made


class TestPasswords:
    async def test_a_new_password_needs_no_restart(self, postgres_server: Server, tmp_path: Path) -> None:
        file = tmp_path / "password"
        file.write_text(f"{PASSWORD}\n")
        async with Database(postgres_server.url, file, sleep=soon) as database, postgres_server.admin() as admin:
            await admin.execute(f"ALTER USER openrois PASSWORD '{PASSWORD}-2'")
            file.write_text(f"{PASSWORD}-2")
            try:
                await admin.execute(CUT)
                async with asyncio.timeout(PATIENT):
                    await until_linked(database)
            finally:
                await admin.execute(f"ALTER USER openrois PASSWORD '{PASSWORD}'")

    async def test_a_wrong_one_is_told_without_it(
        self, postgres_server: Server, tmp_path: Path, caplog: pytest.LogCaptureFixture
    ) -> None:
        caplog.set_level(logging.DEBUG)
        file = tmp_path / "password"
        file.write_text("wrong-and-hidden")
        with pytest.raises(StoreUnreachable) as refused:
            async with Database(postgres_server.url, file):
                pass
        folder = postgres_server.password_file.parent
        assert str(refused.value) == (
            f'PostgreSQL {folder}/postgres: password authentication failed for user "openrois"'
        )
        assert "hidden" not in caplog.text

    async def test_a_file_that_goes_away_is_told(self, postgres_server: Server, tmp_path: Path) -> None:
        file = tmp_path / "password"
        shutil.copy(postgres_server.password_file, file)
        database = Database(postgres_server.url, file)
        file.unlink()
        with pytest.raises(StoreUnreachable, match=r"the password of the store, .*, cannot be read: No such file"):
            async with database:
                pass

    @pytest.mark.parametrize(
        ("content", "problem"),
        [
            (b"", "is no password: it is empty"),
            (b"x" * 5000, "has more than 4096 characters"),
            (b"\xff\xfe", "it is not plain text"),
            (None, "cannot be read: No such file or directory"),
        ],
    )
    def test_a_file_that_holds_none_is_refused_at_once(
        self, tmp_path: Path, content: bytes | None, problem: str
    ) -> None:
        file = tmp_path / "password"
        if content is not None:
            file.write_bytes(content)
        with pytest.raises(ValueError, match=problem):
            Database("postgresql://openrois@localhost/store", file)


class TestTls:
    async def test_a_certificate_is_verified(
        self, postgres_server: Server, tmp_path: Path, tmp_path_factory: pytest.TempPathFactory
    ) -> None:
        authority, stranger = Authority(tmp_path), Authority(tmp_path_factory.mktemp("stranger"))
        port, files = free_port(), []
        for name, made in zip(("cert.pem", "cert.key"), authority.issue(), strict=True):
            files.append(postgres_server.data.parent / name)
            shutil.move(made, files[-1])
            postgres_server.own(files[-1])
        settings = {"ssl": "on", "ssl_cert_file": str(files[0]), "ssl_key_file": str(files[1])}
        with postgres_server.configured(listen_addresses="127.0.0.1", port=str(port), **settings):
            url = f"postgresql://openrois@127.0.0.1:{port}/postgres?sslmode=verify-full&sslrootcert="
            async with (
                Database(f"{url}{authority.file}", postgres_server.password_file) as database,
                database.connection() as connection,
            ):
                assert await connection.fetchval("SELECT ssl FROM pg_stat_ssl WHERE pid = pg_backend_pid()")
            with pytest.raises(StoreUnreachable, match=f"127.0.0.1:{port}/postgres: its certificate is not trusted: "):
                async with Database(f"{url}{stranger.file}", postgres_server.password_file):
                    pass


class TestStart:
    async def test_a_server_that_is_not_there_is_named(self, tmp_path: Path) -> None:
        with pytest.raises(StoreUnreachable, match=f"^PostgreSQL {tmp_path}/store: "):
            async with Database(f"postgresql://openrois@/store?host={tmp_path}"):
                pass

    async def test_a_database_that_is_not_there_is_named(self, postgres_server: Server) -> None:
        url = postgres_server.url.replace("/postgres?", "/missing?")
        with pytest.raises(StoreUnreachable, match='/missing: database "missing" does not exist'):
            async with Database(url, postgres_server.password_file):
                pass

    async def test_an_option_that_postgresql_does_not_know_is_told(self, postgres_server: Server) -> None:
        with pytest.raises(StoreUnreachable, match="sslmode"):
            async with Database(f"{postgres_server.url}&sslmode=nonsense", postgres_server.password_file):
                pass

    async def test_a_schema_that_is_newer_by_two_is_refused(self, postgres_server: Server) -> None:
        async with postgres_server.admin() as admin:
            await migrate(admin, (*STEPS, *[Step("SELECT 1", "SELECT 1")] * 2))
            try:
                with pytest.raises(StoreUnusable, match="install a newer one"):
                    async with Database(postgres_server.url, postgres_server.password_file):
                        pass
            finally:
                await admin.execute("DROP SCHEMA openrois CASCADE")


class TestConnections:
    async def test_they_are_used_again_and_are_few(self, database: Database) -> None:
        used = set()

        async def ask() -> None:
            async with database.connection() as connection:
                used.add(await connection.fetchval("SELECT pg_backend_pid() FROM pg_sleep(0.001)"))

        await asyncio.gather(*(ask() for _ in range(50)))
        assert 1 <= len(used) <= CONNECTIONS

    async def test_the_servers_list_names_the_gateway(self, database: Database) -> None:
        async with database.connection() as connection:
            assert await connection.fetchval("SHOW application_name") == "openrois a"

    async def test_one_that_is_given_up_is_cut_and_the_next_call_works(self, database: Database) -> None:
        with pytest.raises(TimeoutError):
            async with asyncio.timeout(0.05), database.connection() as connection:
                await connection.execute("SELECT pg_sleep(60)")
        assert connection.is_closed()
        async with database.connection() as connection:
            assert await connection.fetchval("SELECT 1") == 1

    async def test_the_one_that_stays_is_there_from_the_beginning(
        self, postgres_server: Server, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        monkeypatch.setattr("openrois.cluster.postgres.database._RELINKING", 0.0)
        async with Database(postgres_server.url, postgres_server.password_file) as database, database.link() as link:
            assert await link.fetchval("SELECT 1") == 1

    async def test_what_the_server_refuses_is_told_in_one_line(self, database: Database) -> None:
        with pytest.raises(StoreUnreachable, match=r'/postgres: relation "nothing" does not exist$'):
            async with database.connection() as connection:
                await connection.execute("SELECT * FROM nothing")

    async def test_those_that_were_cut_are_made_again(self, postgres_server: Server, database: Database) -> None:
        async with postgres_server.admin() as admin:
            await admin.execute(CUT)
        async with asyncio.timeout(PATIENT):
            await until_linked(database)
        async with database.connection() as connection:
            assert await connection.fetchval("SELECT 1") == 1


class TestListening:
    async def test_what_is_notified_reaches_those_that_listen_to_its_topic(
        self, postgres_server: Server, database: Database
    ) -> None:
        heard: asyncio.Queue[str | None] = asyncio.Queue()
        leave = database.listen("lamp", heard.put_nowait)
        async with asyncio.timeout(PATIENT), postgres_server.admin() as admin:
            await until_linked(database)
            for text in ("owner kachaka", "nonsense", "lamp is on", "lamp "):
                await admin.execute("SELECT pg_notify('openrois', $1)", text)
            said = [await heard.get() for _ in range(heard.qsize() or 1)]
            while said[-1] != "":
                said.append(await heard.get())
            assert [each for each in said if each is not None] == ["is on", ""]
            leave()
            leave()

    async def test_after_each_reconnect_something_may_have_been_missed(
        self, postgres_server: Server, database: Database
    ) -> None:
        async with asyncio.timeout(PATIENT), postgres_server.admin() as admin:
            await until_linked(database)
            heard: asyncio.Queue[str | None] = asyncio.Queue()
            database.listen("lamp", heard.put_nowait)
            for _ in range(2):
                await admin.execute(CUT)
                assert await heard.get() is None
                await until_linked(database)

    async def test_why_it_does_not_come_back_is_told(self, postgres_server: Server, database: Database) -> None:
        async with asyncio.timeout(PATIENT):
            await until_linked(database)
            postgres_server.kill()
            try:
                with pytest.raises(StoreUnreachable, match=r"/postgres: .*(connection|lost|closed|No such)"):
                    await use_until_it_fails(database)
            finally:
                postgres_server.start()
            await until_linked(database)


async def until_linked(database: Database) -> None:
    """Wait until the connection that stays is there."""
    while True:
        try:
            async with database.link() as link:
                await link.execute("SELECT 1")
                return
        except StoreUnreachable:
            await asyncio.sleep(0)


async def use_until_it_fails(database: Database) -> None:
    """Use the connection that stays until it is gone."""
    while True:
        async with database.link() as link:
            await link.execute("SELECT 1")
