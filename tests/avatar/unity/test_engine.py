"""The engine of the package for Unity under Mono, beside the real adapter: pictures, commands, faults, and returns."""

import asyncio
import json
from collections.abc import AsyncIterator, Sequence
from contextlib import asynccontextmanager
from pathlib import Path

import pytest
from openrois_avatar.check.acting import Patience
from openrois_avatar.check.finding import Finding, Outcome
from openrois_avatar.check.visit import visiting
from openrois_avatar.link.messages import Completed, Event, Floor, Hello, Quit, React, Welcome
from openrois_avatar.link.protocol import MessageType
from openrois_avatar.link.server import LinkServer
from openrois_streaming.source import RawVideo

from tests.support.avatar_link import wire
from tests.support.mono import Mono
from tests.support.unity import console, player

pytestmark = [pytest.mark.engine, pytest.mark.timeout(90)]

PATIENCE = Patience(connect=30, watch=1.0)


@pytest.fixture(scope="module")
def programs(mono: Mono, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Sequence[str]]:
    """The commands of the engines."""
    folder = tmp_path_factory.mktemp("engines")
    plain, played = str(console(mono, folder)), str(player(mono, folder))
    return {
        "ring": (mono.runtime, plain),
        "socket": (mono.runtime, plain, "", "socket"),
        "unix": (mono.runtime, plain),
        "unity": (mono.runtime, played),
    }


@pytest.fixture(scope="module")
def found(programs: dict[str, Sequence[str]], tmp_path_factory: pytest.TempPathFactory) -> dict[str, list[Finding]]:
    """What `openrois avatar check` finds, of all at once: it waits most of the time."""
    folder = tmp_path_factory.mktemp("link")

    async def findings(name: str) -> list[Finding]:
        address = f"unix:{folder}/engine" if name == "unix" else "tcp:127.0.0.1:0"
        async with visiting(address, "s3cret", programs[name], PATIENCE) as visit:
            return [finding async for finding in visit.findings()]

    async def check_all() -> dict[str, list[Finding]]:
        async with asyncio.timeout(80), asyncio.TaskGroup() as tasks:
            running = {name: tasks.create_task(findings(name)) for name in programs}
        return {name: task.result() for name, task in running.items()}

    return asyncio.run(check_all())


@pytest.mark.parametrize("name", ["ring", "socket", "unix", "unity"])
def test_it_passes_the_check(found: dict[str, list[Finding]], name: str) -> None:
    assert [f"{each.check}: {each.seen}" for each in found[name] if each.outcome is Outcome.FAILED] == []
    passed = {each.check for each in found[name] if each.outcome is Outcome.PASSED}
    assert {"reaction", "stop", "hearing", "input", "walk", "halt", "drive", "sound moments", "quit"} <= passed
    assert ("ring" in passed) is (name != "socket")
    assert "connected again" in next(each.seen for each in found[name] if each.check == "adapter gone")


class Engine:
    """A running engine and the lines that it prints."""

    def __init__(self, process: asyncio.subprocess.Process) -> None:
        self.process = process

    async def said(self, text: str) -> str:
        """The next line with this text."""
        assert self.process.stdout is not None
        async with asyncio.timeout(20):
            while text not in (line := (await self.process.stdout.readline()).decode()):
                assert line, f"it ended without saying {text}"
        return line.strip()


@asynccontextmanager
async def running(*command: str) -> AsyncIterator[Engine]:
    process = await asyncio.create_subprocess_exec(*command, stdout=asyncio.subprocess.PIPE)
    try:
        yield Engine(process)
    finally:
        if process.returncode is None:
            process.kill()
        await process.communicate()


async def test_pictures_are_whole_and_adapters_may_restart(programs: dict[str, Sequence[str]], tmp_path: Path) -> None:
    async with asyncio.timeout(60), asyncio.TaskGroup() as tasks:
        for name in ("ring", "socket"):
            tasks.create_task(two_adapters([*programs[name][:2], f"unix:{tmp_path}/{name}", name]))


async def two_adapters(command: Sequence[str]) -> None:
    """Let an engine, whose second last argument is its address, see two adapters come and go; the third ends it."""
    address = command[-2]
    async with running(*command) as engine:
        await engine.said("not connected")
        for _ in range(2):
            events: list[Event] = []
            async with (
                LinkServer.listen(address, "", on_event=events.append) as server,
                server.video.open() as pictures,
            ):
                connection = await server.accept()
                assert connection.hello.name == "console"
                connection.send_command(React("r", "nod"))
                async for picture in pictures:
                    assert_drawn(picture)
                    if Completed("r", "OK") in events:
                        break
                # What was told before there was an adapter is told to each.
                assert any(isinstance(event, Floor) for event in events)
            assert await engine.said("disconnected") == "disconnected: the adapter ends"
        async with LinkServer.listen(address, "") as server:
            (await server.accept()).send_command(Quit())
            assert await engine.process.wait() == 0


def assert_drawn(picture: RawVideo) -> None:
    """The figure's head is in the middle, lighter than the wall; a white mark goes along the lower edge."""
    assert (picture.width, picture.height, picture.format) == (320, 180, "bgra")
    red = picture.data[..., 2].astype(int)
    assert red[90, 160] == 230
    assert red[20, 20] == 40
    assert red[176].max() == 255
    assert red[4].max() == 40


async def test_a_malformed_adapter_is_told_and_left(programs: dict[str, Sequence[str]]) -> None:
    """It says why to both sides, and tries again."""
    farewells: asyncio.Queue[str] = asyncio.Queue()

    async def adapter(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        body = json.dumps({"command": "walk", "id": "w", "path": [[0, 0]], "speed": 1}).encode()
        malformed = wire(Welcome("mad")) + b"ORL1\5\1\0\0" + len(body).to_bytes(4, "little") + bytes(4) + body
        writer.write(malformed)
        while True:
            header = await reader.readexactly(16)
            payload = await reader.readexactly(int.from_bytes(header[8:12], "little"))
            if header[4] == MessageType.BYE:
                farewells.put_nowait(json.loads(payload)["reason"])
                break
            if header[4] == MessageType.HELLO:
                assert Hello.from_json(json.loads(payload)).name == "console"
        writer.close()

    server = await asyncio.start_server(adapter, "127.0.0.1", 0)
    port = server.sockets[0].getsockname()[1]
    async with server, running(*programs["ring"], f"tcp:127.0.0.1:{port}") as engine:
        for _ in range(2):
            said = await engine.said("disconnected")
            assert said == "disconnected: bad COMMAND: path: expected arrays of 3"
            async with asyncio.timeout(10):
                assert await farewells.get() == "bad COMMAND: path: expected arrays of 3"
