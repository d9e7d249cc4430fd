"""The link server: where it listens, and an engine that joins it."""

import asyncio
import logging
import socket
import stat
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import uvloop
from openrois_avatar.link.connection import MAX_QUEUED_SOUND
from openrois_avatar.link.messages import (
    MAX_TEXT,
    Bitrate,
    Bye,
    Completed,
    Event,
    Floor,
    KeyFrame,
    LinkError,
    Log,
    Look,
    Pause,
    Place,
    Reached,
    React,
    Things,
    Welcome,
)
from openrois_avatar.link.protocol import Audio
from openrois_avatar.link.server import LinkServer
from openrois_streaming.source.source import RawAudio

from tests.support.avatar_link import HELLO, picture
from tests.support.link_world import Engine, World
from tests.support.streaming import VirtualClock, settle

pytestmark = pytest.mark.extra(name="avatar")


def file_type(path: str) -> int | None:
    return stat.S_IFMT(Path(path).stat().st_mode) if Path(path).exists() else None


def private_to_this_user(path: str) -> bool:
    return stat.S_IMODE(Path(path).parent.stat().st_mode) == 0o700


async def test_the_welcome_tells_what_time_it_is(world: World) -> None:
    engine = await world.dial()
    engine.send(world.hello)
    assert await engine.read() == Welcome("openrois-avatar", now_ns=1_000_000_000_000)


async def test_an_engine_joins_and_everything_it_sends_arrives(world: World) -> None:
    engine = await world.join()
    connection = await world.server.accept(5)
    assert connection is world.server.engine
    assert connection.hello == world.hello
    assert connection.connected
    async with asyncio.timeout(60), world.server.video.open() as pictures:
        engine.send(picture(3, 999_990_000_000))
        frame = await anext(pictures)
        assert frame.sequence == 3
        assert frame.captured_at == pytest.approx(999.99)
        np.testing.assert_array_equal(frame.data.reshape(-1), np.arange(32))
        engine.send(Audio(0, 0, 2, b"\1\0\xff\xff"), Completed("1", "OK"), picture(4))
        assert (await anext(pictures)).sequence == 4
    assert world.events == [Completed("1", "OK")]
    assert [(block.samples.tolist(), block.captured_at) for block in world.audio] == [([[1, -1]], 1000.0)]


async def test_commands_reach_the_engine(world: World) -> None:
    engine = await world.join()
    connection = await world.server.accept(5)
    connection.send_command(React("1", "nod"))
    connection.send_command(Look(0.5, 0))
    assert [await engine.read(), await engine.read()] == [React("1", "nod"), Look(0.5, 0)]


def block(value: int, at: float = 1.0) -> RawAudio:
    return RawAudio(np.full((480, 2), value, np.int16), at)


async def test_an_engine_that_wants_to_hears_the_operator(world: World) -> None:
    engine = await world.join()
    connection = await world.server.accept(5)
    connection.send_audio(block(7))
    connection.send_audio(block(-7, -1.0))
    heard = [await engine.read(), await engine.read()]
    assert [
        (each.sequence, each.timestamp_ns, each.channels, set(np.frombuffer(each.samples, "<i2").tolist()))
        for each in heard
        if isinstance(each, Audio)
    ] == [(0, 1_000_000_000, 1, {7}), (1, 0, 1, {-7})]


async def test_an_engine_that_does_not_is_sent_no_sound(world: World) -> None:
    engine = await world.dial()
    engine.send(replace(world.hello, hears=False))
    assert isinstance(await engine.read(), Welcome)
    connection = await world.server.accept(5)
    connection.send_audio(block(7))
    connection.send_command(Look(0, 0))
    assert await engine.read() == Look(0, 0)


async def test_newest_of_unread_sound_is_kept_and_the_engine_stays_connected(world: World) -> None:
    engine = await world.join()
    connection = await world.server.accept(5)
    engine.writer.transport.pause_reading()  # type: ignore[attr-defined]
    total = 3000
    for number in range(total):
        connection.send_audio(block(number))
    connection.send_command(Look(0, 0))
    assert connection.connected
    engine.writer.transport.resume_reading()  # type: ignore[attr-defined]
    heard: list[int] = []
    looked = False
    while not looked or heard[-1] != total - 1:
        message = await engine.read()
        looked = looked or message == Look(0, 0)
        if isinstance(message, Audio):
            heard.append(message.sequence)
    assert heard == sorted(heard)
    assert len(heard) < total
    assert heard[-MAX_QUEUED_SOUND:] == list(range(total - MAX_QUEUED_SOUND, total))


async def test_the_end_of_the_context_says_goodbye_and_leaves_nothing_behind() -> None:
    async with LinkServer.listen() as server:
        world = World(server, [], [])
        engine, stranger = await world.join(), await world.dial()
        connection = await server.accept(5)
        await settle()  # the stranger is let in
        path = server.address.removeprefix("unix:")
        assert file_type(path) == stat.S_IFSOCK
        assert private_to_this_user(path)
    assert [await engine.read(), await engine.read()] == [Bye("the adapter ends"), None]
    assert [await stranger.read(), await stranger.read()] == [Bye("the adapter ends"), None]
    assert file_type(path) is None
    assert await connection.closed() == "the adapter ends"
    with pytest.raises(
        LinkError, match="the engine is disconnected: the adapter ends; try again when one is connected"
    ):
        connection.send_command(React("1", "nod"))
    await engine.aclose()
    await stranger.aclose()


async def test_requests_of_the_media_plane_reach_an_encoding_engine(world: World) -> None:
    engine = await world.dial()
    engine.send(replace(world.hello, video=replace(world.hello.video, format="h264")))
    async with world.server.encoded.open():
        assert isinstance(await engine.read(), Welcome)
        assert await engine.read() == KeyFrame()
        world.server.encoded.set_bitrate(400_000)
        assert await engine.read() == Bitrate(400_000)


async def test_every_event_arrives(world: World) -> None:
    engine = await world.join()
    events: list[Event] = [
        Reached("1", 0),
        Place(0.0, 0.0, 1.0),
        Floor(((0.0, 0.0), (1.0, 0.0), (1.0, 1.0)), ()),
        Things(()),
        Pause(True),
    ]
    engine.send(*events, Bye("end"))
    await (await world.server.accept(5)).closed()
    assert world.events == events


async def test_an_engine_that_comes_and_goes_is_not_accepted(world: World) -> None:
    first = await world.join()
    gone = world.server.engine
    assert gone is not None
    first.send(Bye("no display"))
    assert await gone.closed() == "no display"
    second = await world.join()
    connection = await world.server.accept(5)
    assert connection is not gone
    second.writer.close()
    async with asyncio.timeout(5):
        assert await connection.closed() == "the engine closed the connection"
    with pytest.raises(TimeoutError):
        await world.server.accept(0)


async def test_pictures_of_the_next_engine_go_into_the_same_source(world: World) -> None:
    async with asyncio.timeout(60), world.server.video.open() as pictures:
        first = await world.join()
        first.send(picture(0), picture(1))
        while (await anext(pictures)).sequence != 1:
            pass
        first.writer.close()
        assert world.server.engine is not None
        await world.server.engine.closed()
        second = await world.join()
        second.send(picture(0))
        assert (await anext(pictures)).sequence == 2


async def test_a_welcomed_engine_may_be_quiet() -> None:
    async with asyncio.timeout(60), LinkServer.listen(greeting_timeout=0.02) as server:
        world = World(server, [], [])
        answer: object = None
        while not isinstance(answer, Welcome):
            engine = await world.dial()
            engine.send(world.hello)
            # A busy machine may be too late with it.
            answer = await engine.read()
            if not isinstance(answer, Welcome):
                await engine.aclose()
        stranger = await world.dial()  # its deadline comes after the engine's would have
        assert await stranger.read() == Bye("no HELLO in time; send it as soon as the connection is open")
        (await server.accept(5)).send_command(React("1", "nod"))
        assert await engine.read() == React("1", "nod")
        await engine.aclose()
        await stranger.aclose()


async def test_failing_receiver_does_not_harm_the_connection(caplog: pytest.LogCaptureFixture) -> None:
    seen = list[Event]()

    def fail_first(event: Event) -> None:
        seen.append(event)
        if len(seen) == 1:
            raise ZeroDivisionError

    async with LinkServer.listen(on_event=fail_first) as server:
        engine = await World(server, [], []).join()
        with caplog.at_level(logging.ERROR):
            engine.send(Log("a"), Audio(0, 0, 1, b""), Log("b"), Bye("x" * MAX_TEXT))
            await (await server.accept(5)).closed()
        await engine.aclose()
    assert seen == [Log("a"), Log("b")]
    assert "a receiver failed" in caplog.text


async def test_only_a_welcomed_engine_has_a_hello(world: World) -> None:
    await world.dial()
    await settle()
    (connection,) = world.server._connections
    with pytest.raises(LinkError, match=r"has not been welcomed; wait for `LinkServer.accept`"):
        _ = connection.hello


async def test_server_listens_on_loopback_tcp() -> None:
    async with LinkServer.listen("tcp:127.0.0.1:0", "s3cret") as server:
        host, port = server.address.removeprefix("tcp:").split(":")
        engine = Engine(*await asyncio.open_connection(host, int(port)))
        engine.send(replace(HELLO, secret="s3cret"))
        assert isinstance(await engine.read(), Welcome)
        await engine.aclose()


@pytest.mark.parametrize("host", ["0.0.0.0", "192.0.2.1", "[2001:db8::1]", "example.org"])
async def test_server_refuses_an_address_beyond_loopback(host: str) -> None:
    with pytest.raises(LinkError, match="stays on this machine"):
        async with LinkServer.listen(f"tcp:{host}:0"):
            pass


async def test_an_address_that_cannot_be_had_is_named() -> None:
    async with LinkServer.listen("tcp:127.0.0.1:0") as server:
        with pytest.raises(
            LinkError, match=f"cannot listen on {server.address}: .*; free it, or choose another address"
        ):
            async with LinkServer.listen(server.address):
                pass


async def test_engine_that_connects_during_the_shutdown_is_closed() -> None:
    async with LinkServer.listen() as server:
        late = await World(server, [], []).dial()
    with suppress(ConnectionResetError):
        assert await late.read() is None
    await late.aclose()


async def test_server_goes_on_when_connections_cannot_be_accepted(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    def too_many_files(_: socket.socket) -> None:
        raise OSError(24, "Too many open files")

    clock = VirtualClock()
    async with LinkServer.listen(clock=clock) as server:
        world = World(server, [], [])
        monkeypatch.setattr(socket.socket, "accept", too_many_files)
        engine = await world.dial()
        async with asyncio.timeout(60):
            while not clock.sleepers:
                await settle()
        assert "cannot accept a connection: [Errno 24] Too many open files" in caplog.text
        monkeypatch.undo()
        await clock.advance(1)
        engine.send(world.hello)
        assert isinstance(await engine.read(), Welcome)
        await engine.aclose()


async def test_a_given_path_is_removed_at_the_end(tmp_path: Path) -> None:
    path = f"{tmp_path}/engine"
    async with LinkServer.listen(f"unix:{path}") as server:
        assert server.address == f"unix:{path}"
        assert file_type(path) == stat.S_IFSOCK
    assert file_type(path) is None


def test_link_works_under_uvloop() -> None:
    async def converse() -> None:
        async with asyncio.timeout(60), LinkServer.listen() as server, server.video.open() as pictures:
            world = World(server, [], [])
            engine, stranger = await world.join(), await world.dial()
            engine.send(picture(5))
            assert (await anext(pictures)).sequence == 5
            connection = await server.accept()
            connection.send_command(React("1", "nod"))
            assert await engine.read() == React("1", "nod")
            stranger.writer.write(b"garbage garbage ")
            assert isinstance(await stranger.read(), Bye)
            engine.send(Bye("done"))
            assert await connection.closed() == "done"
            await engine.aclose()
            await stranger.aclose()

    uvloop.run(converse())
