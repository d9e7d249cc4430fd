"""The Godot demo as it is used: a real Godot under a real display server, on the adapter's engine link."""

import asyncio
import os
import signal
import sys
import textwrap
import time
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from dataclasses import dataclass, field
from math import hypot, pi
from pathlib import Path

import cv2
import numpy as np
import psutil
import pytest
import pytest_asyncio
from openrois_avatar.engines.godot import project
from openrois_avatar.engines.selection import link_address
from openrois_avatar.link.address import ADDRESS_VARIABLE, SECRET_VARIABLE
from openrois_avatar.link.embedded import EmbeddedEngine
from openrois_avatar.link.messages import (
    Command,
    Completed,
    Drive,
    Event,
    Floor,
    Halt,
    Hello,
    Input,
    Look,
    Place,
    Quit,
    Reached,
    React,
    Silence,
    Speak,
    Stop,
    Things,
    Viseme,
    Walk,
    Waypoint,
)
from openrois_avatar.link.server import LinkServer
from openrois_streaming.source.source import RawAudio, RawVideo

from openrois.gateway.server import run_gateway
from openrois.gateway.settings import GatewaySettings
from tests.support.demo import end, first_line, free_port, start
from tests.support.engine_child import PATIENCE, difference

pytestmark = [pytest.mark.engine, pytest.mark.timeout(120), pytest.mark.asyncio(loop_scope="module")]

MODULE = "openrois_avatar.engines.godot"
MOUTH = slice(90, 118), slice(295, 345)


@dataclass(slots=True)
class Engine:
    """Godot on the link: what it says and shows from now on."""

    embedded: EmbeddedEngine
    pictures: AsyncIterator[RawVideo]
    sound: list[RawAudio]
    events: list[Event]
    ends: list[str] = field(default_factory=list)
    returns: list[Hello] = field(default_factory=list)

    def send(self, *commands: Command) -> None:
        for command in commands:
            self.embedded.send(command)

    async def take(self, count: int = 1) -> RawVideo:
        """The picture after so many."""
        async with asyncio.timeout(PATIENCE):
            for _ in range(count):
                picture = await anext(self.pictures)
        return picture

    async def until(self, seen: Callable[[RawVideo], bool]) -> RawVideo:
        async with asyncio.timeout(PATIENCE):
            while not seen(picture := await anext(self.pictures)):
                pass
        return picture

    async def told(self, *events: Event) -> None:
        """Wait until the engine has sent all these events."""
        await self.until(lambda _: all(event in self.events for event in events))

    async def still(self) -> Place:
        """Wait until it stands still: where."""
        places: list[Place] = []
        await self.until(lambda _: places.append(self.place) or places[-10:] == [self.place] * 10)  # type: ignore[func-returns-value]
        return self.place

    @property
    def place(self) -> Place:
        """Where it was last."""
        return next(event for event in reversed(self.events) if isinstance(event, Place))


@asynccontextmanager
async def running() -> AsyncIterator[Engine]:
    sound, events, ends, returns = list[RawAudio](), list[Event](), list[str](), list[Hello]()
    embedded = EmbeddedEngine(
        MODULE,
        address=link_address("godot"),
        on_audio=sound.append,
        on_event=events.append,
        on_lost=ends.append,
        on_back=returns.append,
    )
    async with embedded, embedded.video.open() as pictures:
        yield Engine(embedded, pictures, sound, events, ends, returns)


@pytest_asyncio.fixture(scope="module", loop_scope="module")
async def engine(godot: None) -> AsyncIterator[Engine]:
    # A display of a person's own is not for tests.
    with pytest.MonkeyPatch.context() as patch:
        patch.delenv("DISPLAY", raising=False)
        async with running() as started:
            yield started


async def test_hello_has_capabilities_and_the_place_follows(engine: Engine) -> None:
    hello = engine.embedded.hello
    assert hello is not None
    assert (hello.name, hello.audio_channels, hello.hears, hello.walks) == ("godot", 1, True, True)
    assert hello.input
    assert hello.version.startswith("3.")
    assert {"nod", "bow", "wave", "shrug"} <= set(hello.reactions)
    shape = hello.video
    assert (shape.width, shape.height, shape.fps, shape.format) == (640, 360, 30.0, "i420")
    await engine.told(Place(0.0, 0.0, pytest.approx(-pi / 2, abs=1e-3)))  # type: ignore[arg-type]
    floor = next(event for event in engine.events if isinstance(event, Floor))
    assert floor.outline == ((-3.0, -1.0), (3.0, -1.0), (3.0, 4.0), (-3.0, 4.0))
    assert len(floor.obstacles) == 4
    things = next(event for event in engine.events if isinstance(event, Things))
    assert {"visitor": "person", "table": "object"}.items() <= {each.id: each.kind for each in things.things}.items()


async def test_its_pictures_are_upright_and_of_the_right_colours(engine: Engine) -> None:
    picture = await engine.take(10)
    assert (picture.format, picture.data.shape) == ("i420", (540, 640))
    assert abs(picture.captured_at - time.monotonic()) < 1.0
    blue, green, red = (
        channel.astype(float) for channel in cv2.split(cv2.cvtColor(picture.data, cv2.COLOR_YUV2BGR_I420))
    )
    shirt = slice(150, 190), slice(300, 340)
    assert blue[shirt].mean() > red[shirt].mean() + 40
    ground = slice(340, 358), slice(20, 120)
    assert red[ground].mean() > blue[ground].mean() + 25
    wall = slice(20, 60), slice(390, 500)
    assert min(channel[wall].mean() for channel in (blue, green, red)) > 120


async def test_pictures_and_sound_keep_their_pace_and_time(engine: Engine) -> None:
    first = await engine.take()
    heard = len(engine.sound)
    last = await engine.take(45)
    # A busy machine may make it skip, but never hurry. How many it skips is no matter of a test.
    assert (last.sequence - first.sequence) / (last.captured_at - first.captured_at) < 33
    blocks = engine.sound[heard:]
    assert {block.samples.shape for block in blocks} == {(960, 1)}
    steps = np.diff([block.captured_at for block in blocks]) / 0.02
    assert (np.abs(steps - np.round(steps)) < 0.01).all()
    assert np.median(steps) == pytest.approx(1.0, abs=0.01)
    assert np.median([block.captured_at for block in blocks]) - last.captured_at > -1.5


async def test_speech_moves_the_mouth_and_silence_rests_it(engine: Engine) -> None:
    before = await engine.take()
    engine.send(Speak("s", time.monotonic_ns() + 100_000_000, (Viseme(0.0, "aa", 1.0),), 20_000))
    await engine.until(lambda picture: difference(picture, before, *MOUTH) > 6)
    engine.send(Silence())
    await engine.until(lambda picture: difference(picture, before, *MOUTH) < 3)


async def test_a_reaction_is_seen_and_heard_to_its_end(engine: Engine) -> None:
    before, heard = await engine.take(), len(engine.sound)
    engine.send(React("a", "wave"))
    await engine.until(lambda picture: difference(picture, before) > 1.0)
    await engine.told(Completed("a", "OK"))
    assert max(int(np.abs(block.samples).max()) for block in engine.sound[heard:]) > 1000


async def test_a_reaction_that_is_stopped_replaced_or_unknown_says_so(engine: Engine) -> None:
    engine.send(React("b", "bow"), React("c", "somersault"))
    await engine.told(Completed("c", "ERROR"))
    engine.send(React("d", "nod"))
    await engine.told(Completed("b", "ABORT"))
    engine.send(Stop("d"), React("e", "tilt"), Stop())
    await engine.told(Completed("d", "ABORT"), Completed("e", "ABORT"))


async def test_figure_looks_where_look_says(engine: Engine) -> None:
    before = await engine.take(15)
    engine.send(Look(1.0, 0.5))
    await engine.until(lambda picture: difference(picture, before, slice(60, 160), slice(250, 390)) > 3)
    engine.send(Look(0.0, 0.0))


async def test_input_of_the_operator_moves_the_figure(engine: Engine) -> None:
    head = slice(40, 120), slice(280, 360)
    before = await engine.take(15)
    for down, let_go in (
        ({"keys": ["KeyC"]}, {}),
        ({"gamepad": {"axes": [0, 0], "buttons": [0, 1]}}, {"event": "release", "why": "lost"}),
        ({"event": "key", "code": "KeyC", "down": True}, {"event": "key", "code": "KeyC", "down": False}),
    ):
        engine.send(Input({"seq": 1, "t": 0, **down}))
        await engine.until(lambda picture: difference(picture, before, *head) > 40)
        engine.send(Input({"seq": 2, "t": 1, **let_go}))
        await engine.until(lambda picture: difference(picture, before, *head) < 25)
    # A jump is over by itself.
    engine.send(Input({"seq": 3, "t": 2, "event": "pad", "button": 0, "down": True}))
    await engine.until(lambda picture: difference(picture, before, *head) > 40)
    await engine.until(lambda picture: difference(picture, before, *head) < 25)


async def test_walk_reports_the_points_that_are_reached(engine: Engine) -> None:
    before = await engine.take()
    path = (Waypoint(0.2, 0.2), Waypoint(0.2, 0.2, 0.0), Waypoint(-0.1, 0.1, -pi / 2))
    engine.send(Walk("w", path, 2.0))
    await engine.until(lambda picture: difference(picture, before) > 4)
    await engine.told(*(Reached("w", index) for index in range(3)), Completed("w", "OK"))
    place = await engine.still()
    assert (place.x, place.y, place.th) == (
        pytest.approx(-0.1, abs=0.01),
        pytest.approx(0.1, abs=0.01),
        pytest.approx(-pi / 2, abs=0.03),
    )


async def test_a_driven_figure_stops_by_itself_and_at_what_is_in_its_way(engine: Engine) -> None:
    engine.send(Walk("long", (Waypoint(0.0, 3.0),), 0.5))
    engine.send(Drive(1.0, 0.0, 0.0))
    await engine.told(Completed("long", "ABORT"))
    # It may have gone on for long before a busy machine looks.
    before = engine.events[: engine.events.index(Completed("long", "ABORT"))]
    begin = next(event for event in reversed(before) if isinstance(event, Place))
    moved = await engine.still()
    assert 0.1 < hypot(moved.x - begin.x, moved.y - begin.y) < 0.6
    # The room ends at -1: it does not go through the wall.
    for _ in range(4):
        engine.send(Drive(2.5, 0.0, 0.0))
        await engine.take(10)
    assert -1.0 < (await engine.still()).y < -0.7


async def test_halt_stops_a_walk(engine: Engine) -> None:
    engine.send(Walk("h", (Waypoint(0.0, 0.0),), 0.3))
    await engine.take(10)
    engine.send(Halt())
    await engine.told(Completed("h", "ABORT"))
    assert (await engine.still()).y < -0.3


async def test_killed_engine_comes_back(engine: Engine) -> None:
    engine.events.clear()
    next(child for child in psutil.Process().children(recursive=True) if child.name() == "godot3-runner").kill()
    picture = await engine.take()
    while not engine.returns:
        picture = await engine.take()
    assert len(engine.ends) == 1
    assert picture.data.std() > 20
    await engine.told(Place(0.0, 0.0, pytest.approx(-pi / 2, abs=1e-3)))  # type: ignore[arg-type]
    engine.send(React("again", "nod"), Stop("again"))
    await engine.told(Completed("again", "ABORT"))


@pytest.mark.long
async def test_nothing_is_left_of_it_when_the_adapter_is_killed(godot: None, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("DISPLAY", raising=False)
    port = free_port()
    gateway = f"ws://127.0.0.1:{port}/adapter"
    adapter = start("avatar", "--engine", "godot", "--gateway", gateway)
    try:
        async with run_gateway(GatewaySettings(port=port)):
            assert await asyncio.to_thread(first_line, adapter) == "ready avatar"
        left = psutil.Process(adapter.pid).children(recursive=True)
        assert {"godot3-runner", "Xvfb"} <= {process.name() for process in left}
        os.kill(adapter.pid, signal.SIGKILL)
        assert not psutil.wait_procs(left, timeout=5)[1]
    finally:
        end(adapter)


SMALL_GAME = {
    "project.godot": """
        config_version=4
        [application]
        run/main_scene="res://main.tscn"
        [display]
        window/size/width=320
        window/size/height=180
        [rendering]
        quality/driver/driver_name="GLES2"
    """,
    "main.tscn": """
        [gd_scene load_steps=2 format=2]
        [ext_resource path="res://addons/openrois/link.gd" type="Script" id=1]
        [node name="Game" type="Node"]
        [node name="Top" type="ColorRect" parent="."]
        margin_right = 320.0
        margin_bottom = 90.0
        color = Color( 1, 0, 0, 1 )
        [node name="Bottom" type="ColorRect" parent="."]
        margin_top = 90.0
        margin_right = 320.0
        margin_bottom = 180.0
        color = Color( 0, 0, 1, 1 )
        [node name="Link" type="Node" parent="."]
        script = ExtResource( 1 )
        width = 320
        height = 180
    """,
}


async def test_a_small_game_shows_its_window_and_comes_back_to_an_adapter_that_was_away(
    godot: None, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.delenv("DISPLAY", raising=False)
    for name, text in SMALL_GAME.items():
        (tmp_path / name).write_text(textwrap.dedent(text))
    (tmp_path / "addons").symlink_to(project() / "addons")
    address = link_address("godot")
    environment = dict(os.environ)
    process = None
    try:
        for _ in range(2):
            async with LinkServer.listen(address, "the secret") as server:
                address = server.address
                if process is None:
                    environment |= {ADDRESS_VARIABLE: address, SECRET_VARIABLE: "the secret"}
                    process = await asyncio.create_subprocess_exec(
                        sys.executable, "-m", MODULE, str(tmp_path), env=environment
                    )
                connection = await server.accept(PATIENCE)
                assert (connection.hello.audio_channels, connection.hello.walks) == (None, False)
                async with asyncio.timeout(PATIENCE), server.video.open() as pictures:
                    for _ in range(5):
                        picture = await anext(pictures)
                blue, _, red = cv2.split(cv2.cvtColor(picture.data, cv2.COLOR_YUV2BGR_I420))
                assert red[:88].min() > 240
                assert blue[:88].max() < 15
                assert red[92:].max() < 15
                assert blue[92:].min() > 240
        async with LinkServer.listen(address, "the secret") as server:
            (await server.accept(PATIENCE)).send_command(Quit())
            async with asyncio.timeout(PATIENCE):
                assert process is not None
                assert await process.wait() == 0
    finally:
        if process is not None and process.returncode is None:
            process.kill()
            await process.wait()


async def test_without_a_display_server_it_says_so(godot: None, tmp_path: Path) -> None:
    """A display server that does not start is reported, and not waited for."""
    broken = tmp_path / "Xvfb"
    broken.write_text("#!/bin/sh\necho no screens found >&2\nexit 1\n")
    broken.chmod(0o755)
    environment = {**os.environ, "PATH": f"{tmp_path}:{os.environ['PATH']}"}
    environment.pop("DISPLAY", None)
    process = await asyncio.create_subprocess_exec(
        sys.executable, "-m", MODULE, env=environment, stderr=asyncio.subprocess.PIPE
    )
    async with asyncio.timeout(PATIENCE):
        _, said = await process.communicate()
    assert process.returncode == 1
    assert said.decode().strip() == "Xvfb did not start: no screens found"
