"""How a NATS server admits a gateway, and what nats-py has to be like for that."""

import asyncio
import socket
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest
import uvloop
from nats.aio.client import Client

from openrois.cluster.connection import NatsConnection
from openrois.cluster.handshake import Unreachable
from openrois.cluster.link import NatsLink, NatsSettings
from tests.support.canary import CANARY
from tests.support.certificates import Authority
from tests.support.nats import NatsServer, cluster_name, nats_server, settings, stand_in

pytestmark = pytest.mark.extra(name="cluster")


async def connected(named: NatsSettings) -> NatsConnection:
    return await NatsConnection.open(named, named.servers[0], "test")


async def works(named: NatsSettings) -> bool:
    """Tell whether a message comes back over a connection that has grown beyond what nats-py would hold."""
    connection = await connected(named)
    came: asyncio.Queue[bytes] = asyncio.Queue()
    connection.subscribe(f"{named.prefix}.x", lambda _subject, _headers, payload: came.put_nowait(payload))
    for size in (0, 10, 500_000):
        connection.publish(f"{named.prefix}.x", b"x" * size)
        assert await came.get() == b"x" * size
    assert await connection.flush()
    connection.abort("over")
    assert not await connection.flush()
    return True


async def refusal(named: NatsSettings) -> str:
    with pytest.raises(Unreachable) as raised:
        await connected(named)
    return str(raised.value)


class TestTakingOver:
    """The private names of nats-py that are used mean what they did: a new version that changed them fails here."""

    async def test_a_connection_is_ours_from_its_first_byte(self, shared_nats: NatsServer) -> None:
        before = asyncio.all_tasks()
        assert await works(settings(shared_nats.url))
        # No task of nats-py is left to read, ping or flush.
        assert asyncio.all_tasks() == before

    async def test_a_cancellation_that_it_loses_is_obeyed(
        self, shared_nats: NatsServer, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        # It waits with `asyncio.wait_for`, which before Python 3.12 returns a result that comes with the cancellation.
        connect = Client.connect

        async def lose_a_cancellation(*given: Any, **named: Any) -> None:
            await connect(*given, **named)
            opening.cancel()
            with suppress(asyncio.CancelledError):
                await asyncio.sleep(0)

        monkeypatch.setattr(Client, "connect", lose_a_cancellation)
        before = asyncio.all_tasks()
        opening = asyncio.create_task(connected(settings(shared_nats.url)))
        await asyncio.wait({opening})
        assert opening.cancelled()
        assert asyncio.all_tasks() <= before

    async def test_what_came_with_the_admission_is_read(self) -> None:
        async def talk(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
            writer.write(b'INFO {"max_payload": 65536, "headers": true}\r\n')
            await reader.readuntil(b"PING\r\n")
            writer.write(b"PONG\r\nPING\r\nMSG test 1 5\r\nhe")
            await reader.readuntil(b"PONG\r\n")
            writer.write(b"llo\r\n-ERR 'Permissions Violation for Publish'\r\n-ERR 'Stale Connection'\r\n")
            await reader.read()

        lost: asyncio.Queue[str] = asyncio.Queue()
        async with stand_in(talk) as place:
            url = f"nats://{place}"
            connection = await NatsConnection.open(settings(url), url, "test", lost.put_nowait)
            assert connection.max_payload == 65536
            assert await lost.get() == "NATS ended the connection: 'Stale Connection'"
            assert not connection.is_open
            assert not connection.is_writable

    async def test_what_cannot_be_read_ends_the_connection(self) -> None:
        async def talk(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
            writer.write(b"INFO {}\r\n")
            await reader.readuntil(b"PING\r\n")
            writer.write(b"PONG\r\nMSG nonsense\r\n")
            await reader.read()

        async with stand_in(talk) as place:
            connection = await connected(settings(f"nats://{place}"))
            await connection.lost.wait()
            assert connection.reason.startswith("NATS cannot be understood: ")

    async def test_a_sender_waits_for_a_server_that_does_not_read(self) -> None:
        over = asyncio.Event()

        async def talk(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
            writer.write(b"INFO {}\r\n")
            await reader.readuntil(b"PING\r\n")
            writer.write(b"PONG\r\n")
            await over.wait()
            while await reader.read(1 << 20):
                pass

        async with stand_in(talk) as place:
            connection = await connected(settings(f"nats://{place}"))
            while connection.is_writable:
                connection.publish("x", b"x" * 500_000)
            waiting = asyncio.ensure_future(connection.writable())
            await asyncio.wait({waiting}, timeout=0.05)
            assert not waiting.done()
            over.set()
            await waiting
            assert connection.is_writable
            connection.abort("over")


class TestRefusals:
    async def test_nothing_listens(self, nats: None, tmp_path: Path) -> None:
        server = NatsServer(tmp_path)
        assert (await refusal(settings(server.url))).startswith(f"NATS at {server.url} is not reached: ")

    async def test_nothing_answers(self, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setattr("openrois.cluster.handshake.OPEN_TIMEOUT", 0.05)
        with socket.create_server(("127.0.0.1", 0)) as silent:
            url = f"nats://127.0.0.1:{silent.getsockname()[1]}"
            assert await refusal(settings(url)) == f"NATS at {url} is not reached: nothing answers in time"

    async def test_something_else_answers(self) -> None:
        async def talk(_reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
            writer.write(b"220 mail.example ESMTP\r\n")

        async with stand_in(talk) as place:
            said = await refusal(settings(f"nats://{place}"))
        assert "expecting INFO" in said

    async def test_something_answers_what_trips_nats_py(self) -> None:
        async def talk(_reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
            writer.write(b"INFO 7\r\n")

        async with stand_in(talk) as place:
            said = await refusal(settings(f"nats://{place}"))
        assert said.endswith("what answers there is no NATS server (AttributeError)")


class TestCredentials:
    @pytest.mark.parametrize(
        ("configuration", "right", "wrong"),
        [
            (f'authorization {{ token: "{CANARY}" }}', CANARY, f"{CANARY}-not"),
            (
                f'authorization {{ user: "alice", password: "{CANARY}" }}',
                f"alice\n{CANARY}",
                f"alice\n{CANARY}-not",
            ),
        ],
        ids=["token", "password"],
    )
    async def test_they_come_from_a_file(
        self, nats: None, tmp_path: Path, caplog: pytest.LogCaptureFixture, configuration: str, right: str, wrong: str
    ) -> None:
        file = tmp_path / "credentials"
        with caplog.at_level("DEBUG"), nats_server(tmp_path, configuration) as server:
            named = settings(server.url, credentials_file=file)
            file.write_text(right)
            assert await works(named)
            file.write_text(wrong)
            for said in (await refusal(named), await refusal(settings(server.url))):
                assert said.endswith("it does not admit this gateway (name the file with its credentials)")
                assert CANARY not in said
            file.unlink()
            assert "the credentials for NATS cannot be read from" in await refusal(named)
        assert CANARY not in caplog.text

    async def test_a_link_begins_with_files_that_can_be_read_or_not_at_all(self, tmp_path: Path) -> None:
        for named in (
            settings("nats://127.0.0.1:9", credentials_file=tmp_path / "nothing"),
            settings("nats://127.0.0.1:9", ca_file=tmp_path / "nothing"),
        ):
            with pytest.raises(ValueError, match="nothing"):
                async with NatsLink(named, "a"):
                    raise AssertionError("it must not begin")

    async def test_credentials_that_change_are_read_for_the_next_connection(self, nats: None, tmp_path: Path) -> None:
        file = tmp_path / "credentials"
        file.write_text("wrong")
        with nats_server(tmp_path, f'authorization {{ token: "{CANARY}" }}') as server:
            named = NatsSettings((server.url,), prefix=cluster_name(), credentials_file=file)
            async with NatsLink(named, "a") as link:
                assert "does not admit this gateway" in link.trouble
                there = asyncio.Event()
                link.on_presence(lambda _present: there.set())
                file.write_text(CANARY)
                await there.wait()
                assert link.trouble == ""


class TestEncryption:
    @pytest.fixture
    def authority(self, tmp_path: Path) -> Authority:
        return Authority(tmp_path)

    @staticmethod
    def configuration(authority: Authority, more: str = "") -> str:
        certificate, key = authority.issue()
        return f'tls {{ cert_file: "{certificate}", key_file: "{key}" {more} }}'

    @pytest.mark.parametrize("scheme", ["tls", "nats"])
    async def test_a_connection_is_encrypted(
        self, nats: None, tmp_path: Path, authority: Authority, scheme: str
    ) -> None:
        with nats_server(tmp_path, self.configuration(authority), scheme) as server:
            assert await works(settings(server.url, ca_file=authority.file))

    def test_under_uvloop_as_well(self, nats: None, tmp_path: Path, authority: Authority) -> None:
        with nats_server(tmp_path, self.configuration(authority), "tls") as server:
            named = settings(server.url, ca_file=authority.file)
            with asyncio.Runner(loop_factory=uvloop.new_event_loop) as runner:
                assert runner.run(works(named))

    async def test_an_unknown_authority_is_not_trusted(self, nats: None, tmp_path: Path, authority: Authority) -> None:
        with nats_server(tmp_path, self.configuration(authority), "tls") as server:
            said = await refusal(settings(server.url))
        assert "its certificate is not trusted: " in said
        assert said.endswith("(name the authority's file)")

    async def test_a_gateway_shows_its_certificate(self, nats: None, tmp_path: Path, authority: Authority) -> None:
        more = f', ca_file: "{authority.file}", verify: true'
        with nats_server(tmp_path, self.configuration(authority, more), "tls") as server:
            certificate, key = tmp_path / "cert.pem", tmp_path / "cert.key"
            named = settings(server.url, ca_file=authority.file, certificate_file=certificate, key_file=key)
            assert await works(named)
            await refusal(settings(server.url, ca_file=authority.file))

    async def test_nothing_is_shown_to_a_server_that_does_not_encrypt(self, tmp_path: Path) -> None:
        said: asyncio.Queue[bytes] = asyncio.Queue()
        file = tmp_path / "credentials"
        file.write_text(CANARY)

        async def talk(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
            writer.write(b'INFO {"auth_required": true}\r\n')
            await said.put(await reader.read())

        async with stand_in(talk) as place:
            url = f"tls://{place}"
            refused = await refusal(settings(url, credentials_file=file))
            assert await said.get() == b""
        assert (
            refused == f"NATS at {url} is not reached: it does not encrypt: let it require TLS, or name it with nats://"
        )
