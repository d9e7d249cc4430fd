"""The embedded game engines as they are used: real child processes on a real engine link."""

import asyncio
import time
from collections.abc import AsyncIterator
from importlib import import_module
from math import pi

import numpy as np
import pytest
from openrois_avatar.engines.animation.reactions import REACTIONS
from openrois_avatar.engines.room.plan import ROOM
from openrois_avatar.engines.runner import LINK_LOST
from openrois_avatar.link.messages import (
    Completed,
    Drive,
    Floor,
    Look,
    Place,
    Quit,
    Reached,
    React,
    Silence,
    Speak,
    Stop,
    Viseme,
    Walk,
    Waypoint,
)
from openrois_avatar.link.server import LinkServer

from tests.support.engine_child import PATIENCE, Child, difference, luma, running, start

pytestmark = [pytest.mark.engine, pytest.mark.timeout(120)]

# Where the mouth is while the avatar looks ahead, in a picture of 640 x 360.
MOUTH_ROWS, MOUTH_COLUMNS = slice(160, 205), slice(290, 350)


@pytest.fixture(params=["panda3d", pytest.param("puppet", marks=pytest.mark.long)])
def engine(request: pytest.FixtureRequest) -> str:
    name: str = request.param
    works, hint = import_module(f"openrois_avatar.engines.{name}").available()
    if not works:
        pytest.skip(hint)
    return name


@pytest.fixture
async def child(engine: str) -> AsyncIterator[Child]:
    async with running(engine) as started:
        yield started


async def test_hello_has_name_and_capabilities(child: Child, engine: str) -> None:
    hello = child.connection.hello
    assert hello is not None
    assert (hello.name, hello.reactions, hello.audio_channels) == (engine, tuple(REACTIONS), 1)
    assert hello.walks
    assert (hello.video.width, hello.video.height, hello.video.fps, hello.video.format) == (640, 360, 30.0, "i420")


async def test_engine_sends_a_moving_picture_at_its_rate(child: Child) -> None:
    await child.take(5)
    pictures = await child.take(75)
    first, last = pictures[0], pictures[-1]
    assert (first.format, first.data.shape) == ("i420", (540, 640))
    elapsed = last.captured_at - first.captured_at
    rate = (last.sequence - first.sequence) / elapsed
    # A busy machine may make it skip, but never hurry. How many it skips is no matter of a test.
    assert rate <= 30.1
    assert np.ptp(luma(first)) > 120
    assert luma(first).std() > 25
    assert difference(first, last) > 0.05


async def test_its_sound_is_a_stream_without_gaps_in_its_clock(child: Child) -> None:
    await child.take(45)
    blocks = child.sound[5:45]
    assert len(blocks) == 40
    assert {block.samples.shape for block in blocks} == {(960, 1)}
    steps = np.diff([block.captured_at for block in blocks])
    assert (np.abs(steps / 0.02 - np.round(steps / 0.02)) < 0.01).all()
    assert np.median(steps) == pytest.approx(0.02, abs=1e-4)


async def test_speech_moves_the_mouth_and_silence_rests_it(child: Child) -> None:
    (before,) = await child.take(1)
    start_ns = time.monotonic_ns() + 100_000_000
    child.connection.send_command(Speak("s", start_ns, (Viseme(0.0, "aa", 1.0),), 20_000))
    spoken = await child.until(lambda picture: difference(picture, before, MOUTH_ROWS, MOUTH_COLUMNS) > 12)
    assert spoken.captured_at >= start_ns / 1e9 - 0.1
    child.connection.send_command(Silence())
    await child.until(lambda picture: difference(picture, before, MOUTH_ROWS, MOUTH_COLUMNS) < 6)


@pytest.mark.long
async def test_every_reaction_is_seen(child: Child) -> None:
    for name in REACTIONS:
        child.connection.send_command(Stop())
        await child.take(25)
        (still,) = await child.take(1)
        child.connection.send_command(React(name, name))
        await child.until(lambda picture, still=still: difference(picture, still) > 1.5)  # type: ignore[misc]
    aborted = [event for event in child.events if isinstance(event, Completed)]
    assert [(event.id, event.status) for event in aborted] == [(name, "ABORT") for name in list(REACTIONS)[:-1]]


async def test_a_reaction_ends_with_ok_and_its_sound_is_heard(child: Child) -> None:
    sent = time.monotonic()
    child.connection.send_command(React("a", "nod"))
    assert await child.completed("a") == Completed("a", "OK")
    assert time.monotonic() - sent >= REACTIONS["nod"].duration - 0.05
    assert max(int(np.abs(block.samples).max()) for block in child.sound) > 1000


async def test_a_stopped_or_unknown_reaction_says_so(child: Child) -> None:
    child.connection.send_command(React("a", "bow"))
    await child.take(5)
    child.connection.send_command(Stop("a"))
    assert await child.completed("a") == Completed("a", "ABORT")
    child.connection.send_command(React("b", "somersault"))
    assert await child.completed("b") == Completed("b", "ERROR")


async def test_figure_looks_where_look_says(child: Child) -> None:
    (ahead,) = await child.take(1)
    child.connection.send_command(Look(1.0, 0.0))
    await child.until(lambda picture: difference(picture, ahead) > 2.0)


async def test_figure_walks_where_walk_says_and_stands_after_a_lost_driver(child: Child) -> None:
    (home,) = await child.take(1)
    path = (Waypoint(0.2, 0.4), Waypoint(0.5, 0.4, -pi / 2))
    child.connection.send_command(Walk("a", path, 1.0))
    assert await child.completed("a") == Completed("a", "OK")
    assert [event for event in child.events if isinstance(event, Floor)] == [ROOM.floor]
    (there,) = await child.take(1)
    assert [event for event in child.events if isinstance(event, Reached)] == [Reached("a", 0), Reached("a", 1)]
    places = [event for event in child.events if isinstance(event, Place)]
    assert (places[0], places[-1]) == (Place(0.0, 0.0, -1.5708), Place(0.5, 0.4, -1.5708))
    # One with each picture; a busy machine draws few.
    assert len(places) > 3
    assert difference(home, there) > 8
    child.connection.send_command(Drive(0.6, 0.0, 0.0))
    await child.take(30)
    driven = [event for event in child.events if isinstance(event, Place)]
    assert 0.4 - 0.6 * 0.5 <= driven[-1].y < 0.3
    assert driven[-1].x == pytest.approx(0.5)
    await child.take(10)
    assert [event for event in child.events if isinstance(event, Place)] == driven


async def test_engine_exits_on_quit(child: Child) -> None:
    child.connection.send_command(Quit())
    async with asyncio.timeout(PATIENCE):
        assert await child.process.wait() == 0


async def test_engine_ends_when_the_link_closes(child: Child) -> None:
    await child.take(3)
    child.connection.close("the test ends")
    async with asyncio.timeout(PATIENCE):
        assert await child.process.wait() == 0


async def test_engine_ends_when_it_is_refused(engine: str, capfd: pytest.CaptureFixture[str]) -> None:
    async with LinkServer.listen() as server:
        process = await start(engine, server.address, "not the secret")
        async with asyncio.timeout(PATIENCE):
            assert await process.wait() == LINK_LOST
    assert "refused" in capfd.readouterr().err
