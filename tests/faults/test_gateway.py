"""F7 to F9, F22, F25, F27: the gateway itself is killed, asked to stop, stopped, or has no disk and no files."""

import asyncio
import random
import resource
import signal
import sqlite3
from collections.abc import Iterable
from contextlib import AsyncExitStack, suppress
from functools import partial
from pathlib import Path
from typing import Any

import psutil
import pytest
from aiohttp import ClientSession
from websockets.exceptions import InvalidHandshake

from openrois.adapter.dialer import serve_parent
from openrois.adapter.running import hosted, serve
from openrois.aio.tasks import TaskScope
from openrois.client import Client, Connected, ConnectionState, Reconnect
from openrois.errors import ComponentFailed, RoISError, Unsupported
from openrois.gateway import server
from openrois.journal import file as journal_file
from openrois.journal.file import JournalFile
from openrois.journal.records import Record
from openrois.journal.sqlite_journal import SqliteJournal
from openrois.transport.credentials import NO_CREDENTIALS, Credentials
from tests.support.components import Bell, Lamp
from tests.support.demo import free_port
from tests.support.ground import gateway_program, ground, turns
from tests.support.guarded import fresh
from tests.support.invariants import Book, calm
from tests.support.seeds import ALL, lasting
from tests.support.tokens import key_file

LAMP, BELL = "robot/lamp", "robot/bell"


async def robot(stack: AsyncExitStack, url: str, lamp: Lamp, credentials: Credentials = NO_CREDENTIALS) -> None:
    """Let a robot of this process dial a gateway, soon again whenever that is gone."""

    async def briefly(_seconds: float) -> None:
        await asyncio.sleep(0.05)

    host = await stack.enter_async_context(hosted("robot", lamp, Bell(), Lamp("torch")))
    scope = await stack.enter_async_context(TaskScope())
    address = f"{url.replace('http', 'ws', 1)}adapter"
    scope.start(serve_parent(host, address, credentials=credentials, sleep=briefly))


@pytest.mark.parametrize("seed", lasting(0))
async def test_f7_a_gateway_that_is_killed(seed: int, tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    chance, port, book, lamp = random.Random(seed), str(free_port()), Book(), Lamp()
    start = partial(
        gateway_program, "--port", port, "--journal", str(tmp_path / "journal"), log=tmp_path / "gateway.log"
    )
    url = f"http://127.0.0.1:{port}/"
    count = chance.randint(1, 4)
    async with calm(caplog), AsyncExitStack() as stack:
        async with start() as gateway:
            await robot(stack, url, lamp)
            async with book.witness(url) as app:
                await app.attached()
                assert await app.bind() == "OK"
                assert await app.execute("ended", "switch") == "OK"
                assert await app.end_of("ended") == "OK"
                for number in range(count):
                    units: list[dict[str, Any]] = [
                        {"component_ref": LAMP, "command_type": kind, "command_id": f"{kind}{number}", "arguments": []}
                        for kind in ("start", "switch")
                    ]
                    assert await app.code("rois.command.execute", command_unit_list=units) == "OK"
                client = await stack.enter_async_context(Client(url, reconnect=Reconnect(first=0.05, limit=0.1)))
                torch = client.component("robot/torch")
                await torch.bind()
                running = await client.execute(torch.command("start"), torch.command("switch", times=1))
                ended = [await torch.command("switch", times=1).execute() for _ in range(count)]
                await turns(chance, 100)
                gateway.signal(signal.SIGKILL)
                await app.gone.wait()
        heard = {name: app.how(name) for name in (*app.accepted, "ended") if app.how(name)}
        book.holders.clear()
        async with start(), book.witness(url, extended=True) as again:
            again.inherits(app)
            await again.attached()
            for command_id in app.unfinished():
                result = await again.ask("rois.command.get_command_result", command_id=command_id, condition="")
                status = await again.end_of(command_id)
                assert (result["return_code"], status) in {("ERROR", "ERROR"), ("OK", "ABORT"), ("OK", "OK")}
                if status == "ERROR":
                    assert again.reasons[command_id] == "the gateway was restarted"
            assert heard["ended"] == "OK"
            # The SDK asks by itself, and every handle comes to an end.
            async with asyncio.timeout(10):
                for command in (*running.commands, *ended):
                    await command.wait()
            assert [command.status for command in running.commands] == ["ERROR", "ERROR"]
            with pytest.raises(ComponentFailed, match="the gateway was restarted"):
                await running
            assert {command.status for command in ended} <= {"OK", "ERROR"}
            # No ghost of the former holder.
            assert await again.bind() == "OK"
            assert await again.execute("new", "switch") == "OK"
            assert await again.end_of("new") == "OK"
    book.check()


async def test_f7_what_a_person_has_stopped_stays_so_when_its_gateway_is_killed(tmp_path: Path) -> None:
    chance, port, lamp = random.Random(7), str(free_port()), Lamp()
    url, keys = f"http://127.0.0.1:{port}/", str(key_file(tmp_path))
    start = partial(gateway_program, "--port", port, "--auth-key", keys, log=tmp_path / "gateway.log")
    ann, agent = (
        Client(url, token=fresh(sub=sub, rank=rank, scope=["robot/*"]), reconnect=Reconnect(first=0.05, limit=0.1))
        for sub, rank in (("ann", "person"), ("agent", "agent"))
    )

    async def moves() -> str:
        """Try to move; return why the program may not, or empty text."""
        try:
            await agent.component(LAMP).command("switch", times=1)
        except RoISError as refused:
            return str(refused)
        return ""

    async with AsyncExitStack() as stack:
        async with start() as gateway:
            shown = Credentials(fresh(sub="robot", roles=["adapter"], scope=["robot/*"]))
            await robot(stack, url, lamp, shown)
            for client in (ann, agent):
                await stack.enter_async_context(client)
            async with asyncio.timeout(30):
                while await moves():
                    with suppress(Unsupported):
                        await agent.bind(LAMP)
                    await turns(chance)
            assert lamp.total == 1
            await ann.control.stop_all("robot")
            assert "robot was stopped by ann" in await moves()
            again = agent.notices(Connected)
            gateway.signal(signal.SIGKILL)
            await gateway.ended()
        async with start(), asyncio.timeout(60):
            await anext(again)
            refusals: list[str] = []
            # Until its component is bound again it may not move anyway.
            while sum("robot was stopped by ann" in why for why in refusals) < 100:
                refusals.append(await moves())
                await turns(chance)
            assert "" not in refusals
            assert lamp.total == 1
            await ann.control.release_stop("robot")
            assert await moves() == ""
            assert lamp.total == 2


@pytest.mark.parametrize("seed", lasting(0))
async def test_f8_a_gateway_that_is_told_to_stop(seed: int, tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    chance, book, lamp = random.Random(seed), Book(), Lamp()
    ends = chance.random() < 0.5
    async with calm(caplog), AsyncExitStack() as stack:
        options = ("--port", "0", "--drain", "10" if ends else "0.1")
        gateway = await stack.enter_async_context(gateway_program(*options, log=tmp_path / "gateway.log"))
        url = gateway.first.removeprefix("listening ")
        await robot(stack, url, lamp)
        apps = [await stack.enter_async_context(book.witness(url, extended=True)) for _ in range(5)]
        await apps[0].attached()
        assert await apps[0].bind() == "OK"
        assert await apps[0].execute("runs") == "OK"
        async with asyncio.timeout(5):
            await lamp.glowing.wait()
        gateway.signal(signal.SIGTERM)
        async with ClientSession() as http, asyncio.timeout(5):
            while ends:
                async with http.get(f"{url}readyz") as answer:
                    if answer.status == 503:
                        break
        if ends:
            await turns(chance, 100)
            lamp.may_end.set()
        assert await apps[0].end_of("runs") == ("OK" if ends else "ABORT")
        for each in apps:
            async with asyncio.timeout(5):
                await each.gone.wait()
            assert each.close_code == 1012
            assert 2 <= float(each.close_reason.removeprefix("retry_after=")) < 2.1
        assert await gateway.ended() == 0
        assert "Traceback" not in gateway.log()
    book.check()


@pytest.mark.parametrize("clients", [100, pytest.param(1000, marks=[pytest.mark.long, pytest.mark.timeout(600)])])
async def test_f9_all_come_back_after_a_restart(clients: int, tmp_path: Path) -> None:
    port = str(free_port())
    url = f"http://127.0.0.1:{port}/"
    # All have one address here, and a busy machine is slow to greet each.
    options = ("--port", port, "--silent", "1024", "--silent-per-address", "1024")
    start = partial(gateway_program, *options, log=tmp_path / "gateway.log")
    loop = asyncio.get_running_loop()
    async with AsyncExitStack() as stack:
        async with start() as gateway:
            await stack.enter_async_context(serve(Lamp(), engine_id="robot", gateway=url))
            apps = [Client(url) for _ in range(clients)]
            for many in range(0, clients, 10):
                await asyncio.gather(*(stack.enter_async_context(each) for each in apps[many : many + 10]))
            gateway.signal(signal.SIGTERM)
            assert await gateway.ended() == 0
        async with start():
            began = loop.time()
            async with asyncio.timeout(60):
                # Who looks was not there before, and was not asked to wait.
                async with Book().witness(url) as looks:
                    await looks.attached()
                robot_after = loop.time() - began
                while any(each.state is not ConnectionState.CONNECTED for each in apps):  # noqa: ASYNC110 - all of them
                    await asyncio.sleep(0.05)
                after = loop.time() - began
            print(f"{clients} clients were back after {after:.1f} s, the robot after {robot_after:.1f} s")
            for each in apps[:: clients // 20]:
                assert await each.search() == (LAMP,)


@pytest.mark.parametrize("seed", lasting(0))
async def test_f22_a_gateway_that_was_suspended(seed: int, tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    chance, book, lamp = random.Random(seed), Book(), Lamp()
    async with calm(caplog), AsyncExitStack() as stack:
        options = ("--port", "0", "--adapter-timeout", "0.8")
        gateway = await stack.enter_async_context(gateway_program(*options, log=tmp_path / "gateway.log"))
        url = gateway.first.removeprefix("listening ")
        await robot(stack, url, lamp)
        app = await stack.enter_async_context(book.witness(url, extended=True))
        await app.attached()
        await app.ask("rois.system.connect")
        assert await app.bind() == "OK"
        assert await app.execute("runs") == "OK"
        # These stand between the gateway and the robot when the gateway stops.
        condition = f"component_ref = '{LAMP}'"
        asked = [
            await app.begin("rois.query.query", query_type="brightness", condition=condition)
            for _ in range(chance.randint(20, 60))
        ]
        await turns(chance, 30)
        gateway.signal(signal.SIGSTOP)
        await asyncio.sleep(1.4 + chance.random() * 0.3)
        lamp.may_end.set()
        gateway.signal(signal.SIGCONT)
        async with asyncio.timeout(5):
            codes = {(await each)["result"]["return_code"] for each in asked}
        assert codes == {"OK"}
        assert await app.end_of("runs") == "OK"
        assert await app.execute("after", "switch") == "OK"
        assert await app.end_of("after") == "OK"
        assert app.errors == []
    book.check()


class FailingDisk(JournalFile):
    """A journal's file whose writes fail by chance, and then all of them."""

    chance = random.Random(0)

    def write(self, records: Iterable[Record]) -> None:
        if self.chance.random() < 0.5:
            raise sqlite3.OperationalError("disk I/O error")
        super().write(records)


@pytest.mark.parametrize("seed", ALL)
async def test_f25_a_disk_that_is_full_or_fails(
    seed: int, tmp_path: Path, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    if seed % 2:
        # SQLite itself says that it is full.
        monkeypatch.setattr(journal_file, "MAX_PAGES", 6)
    else:
        FailingDisk.chance = random.Random(seed)
        monkeypatch.setattr(server, "SqliteJournal", partial(SqliteJournal, open_file=FailingDisk))
    monkeypatch.setattr("openrois.journal.sqlite_journal._RETRY", 0.01)
    full: dict[str, Any] = {"audit_file": Path("/dev/full"), "journal": tmp_path / "journal"}
    async with ground(seed, tmp_path, caplog, audited=False, ready=False, **full) as place:
        await place.robot()
        app = await place.witness(extended=True)
        assert await app.bind() == "OK"
        for number in range(8):
            assert await app.execute(f"{number}-{'x' * 900}", "switch") == "OK"
        await app.settled()
        assert place.lamp.total == 8
        async with ClientSession() as http, http.get(f"{place.gateway.url}healthz") as alive:
            assert alive.status == 200


@pytest.mark.parametrize("seed", lasting(0))
async def test_f27_no_more_files(seed: int, tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    chance, book = random.Random(seed), Book()
    most = chance.randint(48, 72)

    def limited() -> None:
        resource.setrlimit(resource.RLIMIT_NOFILE, (most, most))

    async with calm(caplog), AsyncExitStack() as stack:
        gateway = await stack.enter_async_context(
            gateway_program("--port", "0", log=tmp_path / "gateway.log", preexec_fn=limited)
        )
        url = gateway.first.removeprefix("listening ")
        port = int(url.rsplit(":", 1)[1].strip("/"))
        app = await stack.enter_async_context(book.witness(url))
        crowd = [await asyncio.open_connection("127.0.0.1", port) for _ in range(most + 30)]
        process = psutil.Process(gateway.process.pid)
        before = process.cpu_times().user + process.cpu_times().system
        for _ in range(10):
            assert await app.code("rois.system.get_profile", condition="") == "OK"
            await asyncio.sleep(0.05)
        used = process.cpu_times().user + process.cpu_times().system - before
        assert used < 0.3, "it spins"
        for _, writer in crowd:
            writer.transport.abort()
        async with asyncio.timeout(10):
            while True:
                try:
                    async with book.witness(url) as fresh:
                        assert await fresh.code("rois.system.get_profile", condition="") == "OK"
                    break
                except (OSError, TimeoutError, EOFError, InvalidHandshake):
                    await asyncio.sleep(0.05)
    book.check()
