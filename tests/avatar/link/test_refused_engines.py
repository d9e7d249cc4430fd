"""Connections that the link server refuses or closes: wrong, malformed, too many, or too slow."""

import asyncio
import logging
import socket
import stat
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

import pytest
from openrois_avatar.link.connection import MAX_UNREAD
from openrois_avatar.link.messages import Bye, React, Welcome
from openrois_avatar.link.protocol import Doorbell, Encoded, Parser, PixelFormat, Sender
from openrois_avatar.link.server import MAX_STRANGERS, LinkServer

from tests.support.avatar_link import HELLO, picture, wire
from tests.support.link_world import World

pytestmark = pytest.mark.extra(name="avatar")


def file_type(path: str) -> int | None:
    return stat.S_IFMT(Path(path).stat().st_mode) if Path(path).exists() else None


async def test_a_wrong_secret_is_refused(world: World) -> None:
    engine = await world.dial()
    engine.send(HELLO)
    assert [await engine.read(), await engine.read()] == [
        Bye("wrong secret: HELLO must have the adapter's secret"),
        None,
    ]
    assert world.server.engine is None


async def test_a_second_engine_is_refused_and_the_first_unharmed(world: World) -> None:
    first, second = await world.join(), await world.dial()
    second.send(world.hello)
    assert [await second.read(), await second.read()] == [
        Bye("another engine is connected; end it, or start a second adapter for this one"),
        None,
    ]
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
    assert await first.read() == Bye(
        "bad magic: this is not the engine link, or its framing is lost; begin each message with ORL1, "
        "and send as many bytes as its header says"
    )
    assert "bad magic" in await connection.closed()
    assert not connection.connected
    assert world.server.video.received == 0


async def test_a_doorbell_without_a_ring_is_a_fault(world: World) -> None:
    engine = await world.join()
    engine.send(Doorbell(0, 0, 4, 2, 16, PixelFormat.BGRA, 0))
    assert [await engine.read(), await engine.read()] == [
        Bye("RING: no ring was given; send VIDEO, or HELLO with `ring`"),
        None,
    ]


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
        (encodes, picture(), "VIDEO: HELLO announced h264, and this is raw"),
        (encodes, Doorbell(0, 0, 4, 2, 16, PixelFormat.BGRA, 0), "VIDEO: HELLO announced h264, and this is raw"),
        (encodes, coded, "VIDEO: a NAL unit of type 2 is not allowed"),
        (world.hello, coded, "VIDEO: HELLO announced raw pictures, and this is h264"),
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


async def test_connection_without_hello_is_closed() -> None:
    async with LinkServer.listen(greeting_timeout=0) as server:
        stranger = await World(server, [], []).dial()
        assert [await stranger.read(), await stranger.read()] == [
            Bye("no HELLO in time; send it as soon as the connection is open"),
            None,
        ]
        await stranger.aclose()


async def test_strangers_are_bounded_and_an_engine_still_gets_in(world: World) -> None:
    strangers = [await world.dial() for _ in range(MAX_STRANGERS)]
    one_too_many = await world.dial()
    assert await one_too_many.read() == Bye("too many connections have not sent HELLO; try again later")
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
        assert await connection.closed() == "the engine does not read its commands; read them with every picture"


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
async def test_engine_that_still_sends_gets_the_reason_of_the_close(
    address: str | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("openrois_avatar.link.connection.FAREWELL_TIMEOUT", 60)
    async with LinkServer.listen(address) as server:
        said = wire(replace(HELLO, secret="wrong")) + bytes(16 << 20)
        heard = await asyncio.to_thread(tell_much_and_listen, server.address, said)
    assert Parser(Sender.ADAPTER).feed(heard) == [Bye("wrong secret: HELLO must have the adapter's secret")]


async def test_engine_that_sends_endlessly_is_cut_off(monkeypatch: pytest.MonkeyPatch) -> None:
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
