import asyncio
import logging
import socket
import stat
import time
from collections.abc import AsyncIterator
from contextlib import AsyncExitStack
from dataclasses import dataclass, field, replace
from itertools import islice
from pathlib import Path

import pytest
from openrois_avatar.link.client import LinkClient
from openrois_avatar.link.external import FIRST_PICTURE, ExternalEngine
from openrois_avatar.link.messages import Demand, Hello, Idle, LinkError, Log, Pause, React, VideoShape
from openrois_avatar.link.protocol import PixelFormat
from openrois_avatar.link.reconnecting import connections
from openrois_streaming.source.supervision import CHECK_INTERVAL, HUNG

from tests.support.avatar_link import HELLO
from tests.support.streaming import VirtualClock, settle

ADDRESS = "tcp:127.0.0.1:0"


@dataclass
class World:
    """An adapter that waits for engines, and the notifications about them."""

    engine: ExternalEngine
    clock: VirtualClock
    stack: AsyncExitStack
    told: list[object] = field(default_factory=list)

    async def join(self, hello: Hello = HELLO, until: int = 1) -> LinkClient:
        """Connect an engine, and wait for so many notifications."""
        link = await asyncio.to_thread(LinkClient.connect, self.engine.address, hello)
        self.stack.callback(link.close)
        await self.told_of(until)
        return link

    async def told_of(self, count: int) -> None:
        async with asyncio.timeout(60):
            while len(self.told) < count:
                await settle()

    async def look(self, seconds: float) -> None:
        """Let the clock run, with a look as often as there is one."""
        for _ in range(round(seconds / CHECK_INTERVAL)):
            await self.clock.advance(CHECK_INTERVAL)
            await settle()


@pytest.fixture
async def world() -> AsyncIterator[World]:
    told: list[object] = []
    clock = VirtualClock(now=1000)
    engine = ExternalEngine(
        ADDRESS, "secret", on_event=told.append, on_lost=told.append, on_back=told.append, clock=clock
    )
    async with asyncio.timeout(60), AsyncExitStack() as stack, engine:
        yield World(engine, clock, stack, told)


def picture(link: LinkClient) -> None:
    link.send_video(bytes(32), 4, 2, 16, PixelFormat.BGRA, 0)


async def test_external_scene_starts_without_an_engine(world: World) -> None:
    assert world.engine.hello is None
    with pytest.raises(LinkError, match="no game engine is connected"):
        world.engine.send(React("1", "nod"))
    await world.look(2 * FIRST_PICTURE)
    assert world.told == []


async def test_missing_engine_is_logged(caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.INFO):
        async with ExternalEngine(ADDRESS) as engine:
            assert f"no game engine is connected; one is awaited at {engine.address}" in caplog.text


async def test_engines_come_and_go_and_each_says_what_it_is(world: World) -> None:
    first = await world.join()
    assert world.engine.hello == HELLO
    await asyncio.to_thread(first.close, "coffee")
    await world.told_of(2)
    other = replace(HELLO, name="other", video=VideoShape(8, 4, 60), reactions=("wave",))
    second = await world.join(other, 3)
    second.send_event(Log("hello"))
    await world.told_of(4)
    assert world.told == [HELLO, "coffee", other, Log("hello")]


async def test_commands_reach_whichever_is_there(world: World) -> None:
    for number in (1, 3):
        link = await world.join(until=number)
        world.engine.send(React(str(number), "nod"))
        assert await asyncio.to_thread(link.poll_commands, 5) == [React(str(number), "nod")]
        await asyncio.to_thread(link.close)
        await world.told_of(number + 1)


async def test_engine_that_stops_sending_pictures_is_disconnected(world: World) -> None:
    link = await world.join()
    async with world.engine.video.open() as pictures:
        for _ in range(3):
            picture(link)
            await anext(pictures)
            await world.look(HUNG - 0.4)
        await world.look(1)
    await world.told_of(2)
    assert world.told[1:] == ["no picture has come for a while; send pictures, `pause` or `idle`"]
    await asyncio.to_thread(link.poll_commands, 5)
    assert link.reason == "no picture has come for a while; send pictures, `pause` or `idle`"
    again = await world.join(until=3)
    assert again.connected


async def test_sleeping_engine_stays_connected_while_it_sends_idle(world: World) -> None:
    link = await world.join(replace(HELLO, demand=True))
    assert await asyncio.to_thread(link.poll_commands, 5) == [Demand(0)]
    for count in range(4):
        link.send_event(Idle())
        await world.told_of(2 + count)
        await world.look(HUNG - 0.4)
    assert link.connected
    await world.look(1)
    await world.told_of(6)
    assert world.told[5:] == ["no picture has come for a while; send pictures, `pause` or `idle`"]


async def test_a_sign_of_life_is_no_picture_where_one_is_wanted(world: World) -> None:
    link = await world.join(replace(HELLO, demand=True))
    async with world.engine.video.open() as pictures:
        link.send_video(bytes(32), 4, 2, 16, PixelFormat.BGRA, round(world.clock.now() * 1e9))
        await anext(pictures)
        for count in range(2):
            link.send_event(Idle())
            await world.told_of(2 + count)
            await world.look(HUNG - 0.4)
    await world.told_of(4)
    assert world.told[3:] == ["no picture has come for a while; send pictures, `pause` or `idle`"]


async def test_the_first_picture_may_take_longer(world: World) -> None:
    await world.join()
    await world.look(FIRST_PICTURE - 1)
    assert world.told == [HELLO]
    await world.look(2)
    await world.told_of(2)


async def test_pausing_engine_stays_connected(world: World) -> None:
    link = await world.join()
    link.send_event(Pause(True))
    await world.told_of(2)
    await world.look(2 * FIRST_PICTURE)
    assert world.told == [HELLO, Pause(True)]
    await asyncio.to_thread(link.close)
    await world.told_of(3)
    await world.join(until=4)
    await world.look(FIRST_PICTURE + 1)
    assert world.told[4:] == ["no picture has come for a while; send pictures, `pause` or `idle`"]


async def test_the_end_of_the_adapter_is_no_loss_of_the_engine() -> None:
    told: list[object] = []
    async with ExternalEngine(ADDRESS, on_lost=told.append) as engine:
        link = await asyncio.to_thread(LinkClient.connect, engine.address, HELLO)
    await asyncio.to_thread(link.poll_commands, 5)
    assert link.reason == "the adapter ends"
    await asyncio.to_thread(link.close)
    assert told == []


async def test_without_a_secret_any_will_do_and_with_one_only_that() -> None:
    async with ExternalEngine(ADDRESS) as engine:
        link = await asyncio.to_thread(LinkClient.connect, engine.address, HELLO)
        await asyncio.to_thread(link.close)
    async with ExternalEngine(ADDRESS, "another") as engine:
        with pytest.raises(LinkError, match="wrong secret"):
            await asyncio.to_thread(LinkClient.connect, engine.address, HELLO)


async def test_an_adapter_that_was_killed_leaves_its_address_to_the_next(tmp_path: Path) -> None:
    path = tmp_path / "engine"
    with socket.socket(socket.AF_UNIX) as listener:
        listener.bind(str(path))
    async with ExternalEngine(f"unix:{path}") as engine:
        assert stat.S_IMODE(await asyncio.to_thread(lambda: path.stat().st_mode)) == 0o600
        with pytest.raises(LinkError, match="cannot listen"):
            async with ExternalEngine(engine.address):
                pass
        link = await asyncio.to_thread(LinkClient.connect, engine.address, HELLO)
        await asyncio.to_thread(link.close)


async def test_file_that_is_no_socket_is_kept(tmp_path: Path) -> None:
    (tmp_path / "engine").write_text("precious")
    with pytest.raises(LinkError, match="cannot listen"):
        async with ExternalEngine(f"unix:{tmp_path}/engine"):
            pass
    assert (tmp_path / "engine").read_text() == "precious"


async def test_an_engine_that_connects_again_outlives_its_adapter(tmp_path: Path) -> None:
    path = f"unix:{tmp_path}/engine"

    def live() -> None:
        for link in islice(connections(lambda: LinkClient.connect(path, HELLO), sleep=lambda _: time.sleep(0.01)), 2):
            with link:
                while link.connected:
                    link.poll_commands(1)

    living = asyncio.create_task(asyncio.to_thread(live))
    for _ in range(2):
        async with asyncio.timeout(60), ExternalEngine(path) as engine:
            while engine.hello is None:
                await settle()
    await living
