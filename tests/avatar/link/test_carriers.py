"""What holds for pictures whichever way they take: through the socket or a ring, the socket Unix or TCP."""

import asyncio
import logging
from collections.abc import AsyncIterator, Callable
from contextlib import AsyncExitStack
from dataclasses import dataclass, replace

import numpy as np
import pytest
from numpy.typing import NDArray
from openrois_avatar.link.client import LinkClient
from openrois_avatar.link.messages import Completed, Event, Hello, LinkError, Log, VideoShape
from openrois_avatar.link.protocol import PixelFormat
from openrois_avatar.link.ring import SLOTS, Ring
from openrois_avatar.link.server import LinkServer
from openrois_streaming.source.source import RawVideo

from tests.support.avatar_link import HELLO
from tests.support.streaming import settle

WIDTH, HEIGHT = 64, 36
RANDOM = np.random.default_rng(7)


@dataclass
class World:
    """A server, and how an engine joins it."""

    server: LinkServer
    events: list[Event]
    ring: bool
    stack: AsyncExitStack

    def hello(self, pixel_format: str = "i420") -> Hello:
        return replace(
            HELLO, secret=self.server.secret, video=VideoShape(WIDTH, HEIGHT, 30, pixel_format), ring=self.ring
        )

    async def join(self, pixel_format: str = "i420") -> LinkClient:
        link = await asyncio.to_thread(LinkClient.connect, self.server.address, self.hello(pixel_format))
        self.stack.callback(link.close)
        return link


@pytest.fixture(params=["unix", "tcp", "unix ring", "tcp ring"])
async def world(request: pytest.FixtureRequest) -> AsyncIterator[World]:
    carrier, _, ring = request.param.partition(" ")
    address = None if carrier == "unix" else "tcp:127.0.0.1:0"
    events: list[Event] = []
    async with LinkServer.listen(address, on_event=events.append) as server, AsyncExitStack() as stack:
        yield World(server, events, bool(ring), stack)


@pytest.fixture
async def pictures(world: World) -> AsyncIterator[AsyncIterator[RawVideo]]:
    async with asyncio.timeout(60), world.server.video.open() as pictures:
        yield pictures


def planes(seed: int) -> NDArray[np.uint8]:
    """An I420 picture."""
    return np.random.default_rng(seed).integers(0, 256, (HEIGHT * 3 // 2, WIDTH), np.uint8)


def send(link: LinkClient, data: NDArray[np.uint8], at: int = 0) -> None:
    link.send_video(data, data.shape[1], data.shape[0] * 2 // 3, data.shape[1], PixelFormat.I420, at)


async def until(happened: Callable[[], bool]) -> None:
    async with asyncio.timeout(60):
        while not happened():
            await settle()


def nv12(data: NDArray[np.uint8], stride: int) -> NDArray[np.uint8]:
    """An I420 picture as NV12, upside down and with garbage behind each row."""
    colours = data[HEIGHT:].reshape(2, HEIGHT // 2, WIDTH // 2)
    rows = np.concatenate([data[:HEIGHT][::-1], np.stack(tuple(colours), axis=-1).reshape(HEIGHT // 2, WIDTH)[::-1]])
    return np.pad(rows, ((0, 0), (0, stride - WIDTH)), constant_values=99)


async def test_pictures_arrive_as_they_are(world: World, pictures: AsyncIterator[RawVideo]) -> None:
    link = await world.join()
    for number in range(2 * SLOTS + 1):
        send(link, planes(number), 1)
        picture = await anext(pictures)
        assert (picture.sequence, picture.format, picture.width, picture.height) == (number, "i420", WIDTH, HEIGHT)
        np.testing.assert_array_equal(picture.data, planes(number))
    assert link.dropped_video == world.server.video.dropped == 0


async def test_pictures_are_drawn_where_the_adapter_reads_them(world: World, pictures: AsyncIterator[RawVideo]) -> None:
    link = await world.join()
    rooms: list[NDArray[np.uint8]] = []

    def draw(number: int) -> Callable[[NDArray[np.uint8]], None]:
        def into(room: NDArray[np.uint8]) -> None:
            rooms.append(room)
            room[:] = planes(number).ravel()

        return into

    for number in range(2 * SLOTS + 1):
        link.draw_video(draw(number), WIDTH, HEIGHT, PixelFormat.I420, 1)
        picture = await anext(pictures)
        assert (picture.sequence, picture.format, picture.width, picture.height) == (number, "i420", WIDTH, HEIGHT)
        np.testing.assert_array_equal(picture.data, planes(number))
    assert np.shares_memory(rooms[0], rooms[SLOTS]) is world.ring
    assert link.dropped_video == world.server.video.dropped == 0


async def test_a_picture_that_fails_to_be_drawn_is_not_sent(world: World, pictures: AsyncIterator[RawVideo]) -> None:
    link = await world.join()

    def fail(room: NDArray[np.uint8]) -> None:
        room[:] = 1
        raise ZeroDivisionError

    for number in range(2 * SLOTS):
        with pytest.raises(ZeroDivisionError):
            link.draw_video(fail, WIDTH, HEIGHT, PixelFormat.I420, 1)
        send(link, planes(number), 1)
        np.testing.assert_array_equal((await anext(pictures)).data, planes(number))


async def test_a_picture_that_cannot_be_is_not_drawn(world: World) -> None:
    link = await world.join()
    with pytest.raises(LinkError, match="must be even"):
        link.draw_video(lambda _room: pytest.fail("it was drawn"), WIDTH + 1, HEIGHT, PixelFormat.I420, 0)


async def test_every_layout_is_understood(world: World, pictures: AsyncIterator[RawVideo]) -> None:
    link = await world.join("bgra")
    bgra = RANDOM.integers(0, 256, (HEIGHT, WIDTH, 4), np.uint8)
    link.send_video(bgra[::-1].copy(), WIDTH, HEIGHT, WIDTH * 4, PixelFormat.BGRA, 0, bottom_up=True)
    np.testing.assert_array_equal((await anext(pictures)).data, bgra)
    link.draw_video(lambda room: room.__setitem__(slice(None), bgra.ravel()), WIDTH, HEIGHT, PixelFormat.BGRA, 0)
    np.testing.assert_array_equal((await anext(pictures)).data, bgra)
    link.send_video(nv12(planes(3), 80), WIDTH, HEIGHT, 80, PixelFormat.NV12, 0, bottom_up=True)
    np.testing.assert_array_equal((await anext(pictures)).data, planes(3))


async def test_a_picture_that_was_handed_out_does_not_change(world: World, pictures: AsyncIterator[RawVideo]) -> None:
    link = await world.join()
    send(link, planes(0))
    first = await anext(pictures)
    for number in range(1, 2 * SLOTS):
        send(link, planes(number))
        await anext(pictures)
    np.testing.assert_array_equal(first.data, planes(0))


async def test_newest_of_unread_pictures_is_kept(world: World, pictures: AsyncIterator[RawVideo]) -> None:
    link = await world.join()
    for number in range(3 * SLOTS):
        send(link, planes(number))
    await until(lambda: world.server.video.received + link.dropped_video == 3 * SLOTS)
    picture = await anext(pictures)
    assert picture.sequence == 3 * SLOTS - 1
    np.testing.assert_array_equal(picture.data, planes(picture.sequence))


async def test_the_render_loop_may_draw_into_the_same_buffer(world: World, pictures: AsyncIterator[RawVideo]) -> None:
    link = await world.join()
    canvas = planes(0)
    send(link, canvas)
    canvas[:] = 0
    np.testing.assert_array_equal((await anext(pictures)).data, planes(0))


async def test_events_sent_before_a_picture_are_there_before_it(
    world: World, pictures: AsyncIterator[RawVideo]
) -> None:
    link = await world.join()
    for number in range(SLOTS):
        link.send_event(Completed(str(number), "OK"))
        send(link, planes(number))
        await anext(pictures)
        assert world.events[-1] == Completed(str(number), "OK")


async def test_a_larger_picture_than_announced_arrives_too(world: World, pictures: AsyncIterator[RawVideo]) -> None:
    link = await world.join()
    large = RANDOM.integers(0, 256, (240 * 3 // 2, 320), np.uint8)
    for data in (large, planes(1), large):
        send(link, data)
        np.testing.assert_array_equal((await anext(pictures)).data, data)


async def test_an_engine_that_comes_back_goes_on(world: World, pictures: AsyncIterator[RawVideo]) -> None:
    for number in range(3):
        link = await world.join()
        send(link, planes(number))
        picture = await anext(pictures)
        assert picture.sequence == number
        np.testing.assert_array_equal(picture.data, planes(number))
        connection = world.server.engine
        assert connection is not None
        await asyncio.to_thread(link.close)
        await connection.closed()


async def test_a_picture_that_arrived_is_read_after_the_engine_has_gone(
    world: World, pictures: AsyncIterator[RawVideo]
) -> None:
    link = await world.join()
    send(link, planes(5))
    await until(lambda: world.server.video.received == 1)
    await asyncio.to_thread(link.close)
    await until(lambda: world.server.engine is None)
    np.testing.assert_array_equal((await anext(pictures)).data, planes(5))


async def test_an_engine_without_a_ring_sends_through_the_socket(
    world: World,
    pictures: AsyncIterator[RawVideo],
    monkeypatch: pytest.MonkeyPatch,
    caplog: pytest.LogCaptureFixture,
) -> None:
    monkeypatch.setattr("sys.platform", "an older one")
    with caplog.at_level(logging.WARNING):
        link = await world.join()
    assert ("gets no ring: a ring needs Linux" in caplog.text) is world.ring
    send(link, planes(1))
    np.testing.assert_array_equal((await anext(pictures)).data, planes(1))


async def test_a_ring_that_the_engine_cannot_open_is_done_without(
    world: World, pictures: AsyncIterator[RawVideo], monkeypatch: pytest.MonkeyPatch
) -> None:
    prepare: Callable[[Ring, VideoShape], None] = Ring.__init__

    def somewhere_else(ring: Ring, shape: VideoShape) -> None:
        prepare(ring, shape)
        ring.place = replace(ring.place, path="no/such/place")

    monkeypatch.setattr(Ring, "__init__", somewhere_else)
    link = await world.join()
    send(link, planes(1))
    np.testing.assert_array_equal((await anext(pictures)).data, planes(1))
    said = [event.text for event in world.events if isinstance(event, Log)]
    assert [text.partition(":")[0] for text in said] == ["the ring cannot be opened"] * world.ring
