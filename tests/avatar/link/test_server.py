import asyncio
import logging
import socket
import stat
from collections.abc import AsyncIterator
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import uvloop
from openrois_avatar.link.connection import MAX_UNREAD
from openrois_avatar.link.messages import (
    MAX_TEXT,
    Bitrate,
    Bye,
    Completed,
    Event,
    Floor,
    Hello,
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
from openrois_avatar.link.protocol import Audio, Doorbell, Encoded, Message, Parser, PixelFormat, Sender
from openrois_avatar.link.server import MAX_STRANGERS, LinkServer
from openrois_avatar.link.unheard import MAX_UNHEARD
from openrois_streaming.source.source import RawAudio

from tests.support.avatar_link import HELLO, picture, wire
from tests.support.streaming import VirtualClock, settle


def file_type(path: str) -> int | None:
    return stat.S_IFMT(Path(path).stat().st_mode) if Path(path).exists() else None


def private_to_this_user(path: str) -> bool:
    return stat.S_IMODE(Path(path).parent.stat().st_mode) == 0o700


class Engine:
    """An engine made of one asyncio stream."""

    def __init__(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        self.reader, self.writer = reader, writer
        self._parser = Parser(Sender.ADAPTER)
        self._messages: list[Message] = []

    def send(self, *messages: Message) -> None:
        self.writer.write(wire(*messages))

    async def read(self) -> Message | None:
        """The next message, None at the end of the connection."""
        async with asyncio.timeout(60):
            while not self._messages:
                data = await self.reader.read(65536)
                if not data:
                    return None
                self._messages += self._parser.feed(data)
        return self._messages.pop(0)

    async def aclose(self) -> None:
        self.writer.close()
        with suppress(OSError):
            await self.writer.wait_closed()


class World:
    """A server, what it received, and the engines that connect to it."""

    def __init__(self, server: LinkServer, audio: list[RawAudio], events: list[Event]) -> None:
        self.server, self.audio, self.events = server, audio, events
        self.engines: list[Engine] = []

    @property
    def hello(self) -> Hello:
        return replace(HELLO, secret=self.server.secret)

    async def dial(self) -> Engine:
        engine = Engine(*await asyncio.open_unix_connection(self.server.address.removeprefix("unix:")))
        self.engines.append(engine)
        return engine

    async def join(self) -> Engine:
        engine = await self.dial()
        engine.send(self.hello)
        assert isinstance(await engine.read(), Welcome)
        return engine


@pytest.fixture
async def world() -> AsyncIterator[World]:
    audio, events = list[RawAudio](), list[Event]()
    clock = VirtualClock(now=1000)
    async with LinkServer.listen(on_audio=audio.append, on_event=events.append, clock=clock) as server:
        world = World(server, audio, events)
        yield world
    for engine in world.engines:
        await engine.aclose()


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


async def test_of_sound_that_is_not_read_the_newest_is_kept_and_nobody_is_cut_off(world: World) -> None:
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
    assert heard[-MAX_UNHEARD:] == list(range(total - MAX_UNHEARD, total))


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
    with pytest.raises(LinkError, match="the engine is gone: the adapter ends"):
        connection.send_command(React("1", "nod"))
    await engine.aclose()
    await stranger.aclose()


async def test_a_wrong_secret_is_refused(world: World) -> None:
    engine = await world.dial()
    engine.send(HELLO)
    assert [await engine.read(), await engine.read()] == [Bye("wrong secret"), None]
    assert world.server.engine is None


async def test_a_second_engine_is_refused_and_the_first_unharmed(world: World) -> None:
    first, second = await world.join(), await world.dial()
    second.send(world.hello)
    assert [await second.read(), await second.read()] == [Bye("another engine is connected"), None]
    (await world.server.accept(5)).send_command(React("1", "nod"))
    assert await first.read() == React("1", "nod")


async def test_malformed_input_closes_that_connection_only(world: World, caplog: pytest.LogCaptureFixture) -> None:
    first, second = await world.join(), await world.dial()
    with caplog.at_level(logging.WARNING):
        second.writer.write(b"GET / HTTP/1.1\r\nHost: x\r\n\r\n")
        assert isinstance(await second.read(), Bye)
    assert "bad magic" in caplog.text
    connection = await world.server.accept(5)
    connection.send_command(React("1", "nod"))
    assert await first.read() == React("1", "nod")
    first.writer.write(b"garbage garbage garbage " + wire(picture()))
    assert await first.read() == Bye("bad magic: this is not the engine link, or its framing is lost")
    assert "bad magic" in await connection.closed()
    assert not connection.connected
    assert world.server.video.received == 0


async def test_a_doorbell_without_a_ring_is_a_fault(world: World) -> None:
    engine = await world.join()
    engine.send(Doorbell(0, 0, 4, 2, 16, PixelFormat.BGRA, 0))
    assert [await engine.read(), await engine.read()] == [Bye("RING: no ring was given"), None]


async def test_a_doorbell_that_lies_closes_that_connection_only(world: World) -> None:
    for slot, named in ((9, "slot 9 of 4"), (0, "picture 0 is not in slot 0")):
        engine = await world.dial()
        engine.send(replace(world.hello, ring=True))
        welcome = await engine.read()
        assert isinstance(welcome, Welcome)
        assert welcome.ring is not None
        engine.send(Doorbell(0, 0, 4, 2, 16, PixelFormat.BGRA, slot))
        bye = await engine.read()
        assert isinstance(bye, Bye)
        assert named in bye.reason
        assert await engine.read() is None
        assert world.server.engine is None
        assert file_type(welcome.ring.path) is None


async def test_pictures_are_encoded_where_hello_says_so_and_nowhere_else(world: World) -> None:
    encodes = replace(world.hello, video=replace(world.hello.video, format="h264"), ring=True)
    coded = Encoded(0, 0, 4, 2, True, b"\0\0\1\x02")
    for hello, sent, named in (
        (encodes, picture(), "VIDEO: HELLO announced h264"),
        (encodes, Doorbell(0, 0, 4, 2, 16, PixelFormat.BGRA, 0), "VIDEO: HELLO announced h264"),
        (encodes, coded, "VIDEO: a NAL unit of type 2 has no place"),
        (world.hello, coded, "VIDEO: HELLO announced no h264"),
    ):
        engine = await world.dial()
        engine.send(hello)
        welcome = await engine.read()
        assert isinstance(welcome, Welcome)
        assert welcome.ring is None
        engine.send(sent)
        bye = await engine.read()
        assert isinstance(bye, Bye)
        assert bye.reason.startswith(named)
        assert await engine.read() is None


async def test_what_the_media_plane_asks_reaches_an_engine_that_encodes(world: World) -> None:
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


async def test_who_does_not_greet_is_sent_away() -> None:
    async with LinkServer.listen(greeting_timeout=0) as server:
        stranger = await World(server, [], []).dial()
        assert [await stranger.read(), await stranger.read()] == [Bye("no HELLO in time"), None]
        await stranger.aclose()


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
        assert await stranger.read() == Bye("no HELLO in time")
        (await server.accept(5)).send_command(React("1", "nod"))
        assert await engine.read() == React("1", "nod")
        await engine.aclose()
        await stranger.aclose()


async def test_strangers_are_bounded_and_an_engine_still_gets_in(world: World) -> None:
    strangers = [await world.dial() for _ in range(MAX_STRANGERS)]
    one_too_many = await world.dial()
    assert await one_too_many.read() == Bye("too many connections wait for their greeting")
    strangers[0].send(world.hello)
    assert isinstance(await strangers[0].read(), Welcome)


async def test_an_engine_that_does_not_read_is_cut_off(world: World) -> None:
    await world.join()
    connection = await world.server.accept(5)
    large = React("x" * 30_000, "nod")
    sent = 0
    while connection.connected:
        connection.send_command(large)
        sent += 30_000
        assert sent < 10_000_000
    assert sent > MAX_UNREAD
    async with asyncio.timeout(60):
        assert await connection.closed() == "the engine does not read its commands"


def tell_much_and_listen(address: str, said: bytes) -> bytes:
    """Send everything before anything is read, as an engine does that is in the middle of a picture."""
    if address.startswith("unix:"):
        line = socket.socket(socket.AF_UNIX)
        line.connect(address.removeprefix("unix:"))
    else:
        line = socket.create_connection(("127.0.0.1", int(address.rpartition(":")[2])))
    heard = b""
    with line:
        line.settimeout(60)
        line.sendall(said)
        while data := line.recv(65536):
            heard += data
    return heard


@pytest.mark.parametrize("address", [None, "tcp:127.0.0.1:0"])
async def test_whoever_still_sends_reads_why_it_is_sent_away(
    address: str | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("openrois_avatar.link.connection.FAREWELL_TIMEOUT", 60)
    async with LinkServer.listen(address) as server:
        said = wire(replace(HELLO, secret="wrong")) + bytes(16 << 20)
        heard = await asyncio.to_thread(tell_much_and_listen, server.address, said)
    assert Parser(Sender.ADAPTER).feed(heard) == [Bye("wrong secret")]


async def test_whoever_sends_without_an_end_is_cut(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("openrois_avatar.link.connection.FAREWELL_TIMEOUT", 0.05)

    def flood(address: str) -> int:
        line, sent = socket.create_connection(("127.0.0.1", int(address.rpartition(":")[2]))), 0
        with line, suppress(OSError):
            line.settimeout(60)
            line.sendall(wire(replace(HELLO, secret="wrong")))
            while True:
                sent += line.send(bytes(65536))
        return sent

    async with LinkServer.listen("tcp:127.0.0.1:0") as server, asyncio.timeout(60):
        assert await asyncio.to_thread(flood, server.address) > 0


async def test_a_goodbye_is_not_waited_for_forever(world: World, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("openrois_avatar.link.connection.FAREWELL_TIMEOUT", 0.01)
    monkeypatch.setattr("openrois_avatar.link.connection.MAX_UNREAD", 10_000_000)
    await world.join()
    connection = await world.server.accept(5)
    for _ in range(100):
        connection.send_command(React("x" * 30_000, "nod"))
    connection.close("enough")
    connection.close("and again")
    async with asyncio.timeout(60):
        assert await connection.closed() == "enough"


async def test_a_receiver_that_fails_harms_nobody(caplog: pytest.LogCaptureFixture) -> None:
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
    with pytest.raises(LinkError, match="has not been welcomed"):
        _ = connection.hello


async def test_it_listens_on_loopback_tcp_too() -> None:
    async with LinkServer.listen("tcp:127.0.0.1:0", "s3cret") as server:
        host, port = server.address.removeprefix("tcp:").split(":")
        engine = Engine(*await asyncio.open_connection(host, int(port)))
        engine.send(replace(HELLO, secret="s3cret"))
        assert isinstance(await engine.read(), Welcome)
        await engine.aclose()


@pytest.mark.parametrize("host", ["0.0.0.0", "192.0.2.1", "[2001:db8::1]", "example.org"])
async def test_it_never_listens_to_the_network(host: str) -> None:
    with pytest.raises(LinkError, match="stays on this machine"):
        async with LinkServer.listen(f"tcp:{host}:0"):
            pass


async def test_an_address_that_cannot_be_had_is_named() -> None:
    async with LinkServer.listen("tcp:127.0.0.1:0") as server:
        with pytest.raises(LinkError, match=f"cannot listen on {server.address}"):
            async with LinkServer.listen(server.address):
                pass


async def test_whoever_comes_in_the_last_moment_is_not_left_hanging() -> None:
    async with LinkServer.listen() as server:
        late = await World(server, [], []).dial()
    with suppress(ConnectionResetError):
        assert await late.read() is None
    await late.aclose()


async def test_it_goes_on_when_connections_cannot_be_accepted(
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


def test_it_works_under_uvloop() -> None:
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
