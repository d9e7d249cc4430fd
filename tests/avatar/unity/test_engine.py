"""The engine of the package for Unity under Mono, beside the real adapter: pictures, commands, faults, and returns."""

import asyncio
import base64
import json
from collections.abc import AsyncIterator, Coroutine, Iterator
from contextlib import asynccontextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from openrois_avatar.check.command_checks import Patience
from openrois_avatar.check.finding import Finding, Outcome
from openrois_avatar.check.session import check_session
from openrois_avatar.link.messages import Completed, Event, Floor, Hello, Place, Quit, React, Thing, Things, Welcome
from openrois_avatar.link.protocol import MessageType
from openrois_avatar.link.server import LinkServer
from openrois_avatar.scene import external_scene
from openrois_body.components.reaction import reaction_ref
from openrois_streaming.clock import SystemClock
from openrois_streaming.codecs import H264
from openrois_streaming.publish.video_encoder import VideoEncoder
from openrois_streaming.source.source import RawVideo

from openrois.testing import harness
from tests.support.avatar_link import wire
from tests.support.mono import Mono
from tests.support.streaming import settle
from tests.support.unity import console, encoding, player

pytestmark = [pytest.mark.engine, pytest.mark.timeout(90)]

PATIENCE = Patience(connect=30, watch=1.0)
ANYWHERE = "tcp:127.0.0.1:0"
WIDTH, HEIGHT = 128, 72


def access_units() -> Iterator[bytes]:
    """A key frame, and a picture that follows it."""
    encoder = VideoEncoder(H264, bitrate=300_000, frame_rate=25)
    for number in range(2):
        data = np.full((HEIGHT * 3 // 2, WIDTH), 100 + number, np.uint8)
        (chunk,) = encoder.encode(RawVideo(data, "i420", WIDTH, HEIGHT, number, number / 25), key_frame=number == 0)
        yield chunk.data


@pytest.fixture(scope="module")
def outcomes(mono: Mono, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """What came of everything that is tried with a running engine, all at once: it waits most of the time."""
    folder = tmp_path_factory.mktemp("engines")
    plain, played = started(mono, console(mono, folder)), started(mono, player(mono, folder))
    units = folder / "units"
    units.write_text("\n".join(base64.b64encode(unit).decode() for unit in access_units()))
    encoder = (*started(mono, encoding(mono, folder)), str(units), str(WIDTH), str(HEIGHT))
    trials: dict[str, Coroutine[Any, Any, Any]] = {
        "ring": findings(f"unix:{folder}/engine", *plain),
        "socket": findings(ANYWHERE, *plain, "", "socket"),
        "unity": findings(ANYWHERE, *played),
        "components": components(f"unix:{folder}/fourth", plain),
        "scene": scene(f"unix:{folder}/third", played),
        "encoded": findings(ANYWHERE, *encoder),
        "restart, ring": two_adapters(f"unix:{folder}/first", plain),
        "restart, socket": two_adapters(f"unix:{folder}/second", plain, "socket"),
        "malformed": malformed(plain),
    }

    async def tried() -> list[Any]:
        async with asyncio.timeout(80):
            return await asyncio.gather(*trials.values(), return_exceptions=True)

    return dict(zip(trials, asyncio.run(tried()), strict=True))


def started(mono: Mono, program: Path) -> tuple[str, ...]:
    """The command that runs a program."""
    return tuple(map(str, mono.command(program)))


async def findings(address: str, *command: str) -> dict[str, Finding]:
    """What `openrois avatar check` finds."""
    async with check_session(address, "s3cret", command, PATIENCE) as session:
        return {finding.check: finding async for finding in session.findings()}


def result(outcomes: dict[str, Any], name: str) -> Any:
    if isinstance(outcomes[name], BaseException):
        raise outcomes[name]
    return outcomes[name]


ACTS = {"reaction", "stop", "hearing", "input", "walk", "halt", "drive", "sound moments"}


@pytest.mark.parametrize(
    ("name", "does"),
    [("ring", {"ring", *ACTS}), ("socket", ACTS), ("unity", {"ring", *ACTS}), ("encoded", {"key frame"})],
)
def test_engine_passes_the_check(outcomes: dict[str, Any], name: str, does: set[str]) -> None:
    found: dict[str, Finding] = result(outcomes, name)
    assert [f"{each.check}: {each.seen}" for each in found.values() if each.outcome is Outcome.FAILED] == []
    passed = {each.check for each in found.values() if each.outcome is Outcome.PASSED}
    assert does | {"pictures", "moments", "quit"} <= passed
    assert ("ring" in passed) is ("ring" in does)
    assert "connected again" in found["adapter gone"].seen


class Engine:
    """A running engine and the lines that it prints."""

    def __init__(self, process: asyncio.subprocess.Process) -> None:
        self.process = process

    async def said(self, text: str) -> str:
        """The next line with this text."""
        assert self.process.stdout is not None
        async with asyncio.timeout(60):
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


@pytest.mark.parametrize("way", ["ring", "socket"])
def test_pictures_are_whole_and_adapters_may_restart(outcomes: dict[str, Any], way: str) -> None:
    result(outcomes, f"restart, {way}")


def test_the_components_of_an_avatar_move_it(outcomes: dict[str, Any]) -> None:
    place = result(outcomes, "components")
    assert (place.x, place.y) == pytest.approx((0.5, 0.5), abs=0.01)


async def components(address: str, program: tuple[str, ...]) -> Place:
    """Where the figure is after an application has let it nod, and sent it somewhere."""
    async with (
        external_scene("avatar", address, "", SystemClock()) as scene,
        harness(*scene.components, engine_id="avatar") as client,
        running(*program, address) as engine,
    ):
        await engine.said("connected to")
        while scene.place() is None:
            await settle()
        reaction, navigation = client.component("avatar/reaction"), client.component("avatar/navigation")
        async with reaction.bound(), navigation.bound():
            await reaction.set_parameter(reaction_ref=reaction_ref("nod"))
            await reaction.command("start")
            await navigation.set_parameter(target_positions=("0.5,0.5",))
            await navigation.command("start")
        place = scene.place()
    assert place is not None
    return place


def test_a_scene_of_unity_is_told_in_the_coordinates_of_the_link(outcomes: dict[str, Any]) -> None:
    picture, events = result(outcomes, "scene")
    # The lowest row came first, and was red.
    assert (picture.data[-1, :, 2] == 255).all()
    assert (picture.data[0, :, 0] == 255).all()
    corners = (-2.0, -2.0), (2.0, -2.0), (2.0, 2.0)
    assert Floor(corners, ((corners[0], corners[2], corners[1]),)) in events
    assert Things((Thing("v1", "person", 0.5, 0.25, -1.5708, "Visitor"),)) in rounded(events)
    assert Place(0.5, 0.25, -1.5708) in rounded(events)


def rounded(events: list[Event]) -> list[Event]:
    """With angles as short as those above."""
    short: list[Event] = []
    for event in events:
        match event:
            case Place():
                short.append(replace(event, th=round(event.th, 4)))
            case Things(things):
                short.append(Things(tuple(replace(thing, th=round(thing.th, 4)) for thing in things)))
            case _:
                short.append(event)
    return short


async def scene(address: str, program: tuple[str, ...]) -> tuple[RawVideo, list[Event]]:
    """A picture of the scene of the components for Unity, and the events about it."""
    events: list[Event] = []
    async with (
        LinkServer.listen(address, "", on_event=events.append) as server,
        server.video.open() as pictures,
        running(*program, address) as engine,
    ):
        connection = await server.accept()
        picture = await anext(pictures)
        while not {Place, Floor, Things} <= {type(event) for event in events}:
            await anext(pictures)
        connection.send_command(Quit())
        assert await engine.process.wait() == 0
    return picture, events


async def two_adapters(address: str, program: tuple[str, ...], *way: str) -> None:
    """Let an engine see two adapters come and go; the third ends it."""
    async with running(*program, address, *way) as engine:
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


def test_a_malformed_adapter_is_told_and_left(outcomes: dict[str, Any]) -> None:
    said, farewells = result(outcomes, "malformed")
    assert said == ["disconnected: bad COMMAND: path: expected arrays of 3"] * 2
    assert farewells == ["bad COMMAND: path: expected arrays of 3"] * 2


async def malformed(program: tuple[str, ...]) -> tuple[list[str], list[str]]:
    """What an engine prints, and sends an adapter whose first command is malformed, at two connections."""
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
    async with server, running(*program, f"tcp:127.0.0.1:{port}") as engine:
        said = [await engine.said("disconnected") for _ in range(2)]
        return said, [await farewells.get() for _ in range(2)]
