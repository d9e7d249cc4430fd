"""A path between two sockets, and between an engine and a viewer."""

import asyncio
import socket
from typing import Self

import pytest
from openrois_streaming.testing import ImpairedPath, Impairments
from openrois_streaming.testing.path import Direction

from tests.support.loopback import engine, viewer

pytestmark = pytest.mark.extra(name="streaming")

CANDIDATE = "candidate:1 1 udp 1 {} {} typ host"


class End:
    """A socket that one end of a path might have."""

    def __init__(self, host: str = "127.0.0.1") -> None:
        self.socket = socket.socket(socket.AF_INET6 if ":" in host else socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.bind((host, 0))
        self.socket.setblocking(False)
        self.candidate = CANDIDATE.format(*self.socket.getsockname()[:2])
        self.other: tuple[str, int] = ("", 0)

    def hears(self, candidate: str) -> None:
        _, _, _, _, host, port, *_ = candidate.split()
        self.other = (host, int(port))

    def send(self, data: bytes) -> None:
        self.socket.sendto(data, self.other)

    async def receive(self) -> bytes:
        async with asyncio.timeout(60):
            return (await asyncio.get_running_loop().sock_recvfrom(self.socket, 2000))[0]

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.socket.close()


async def entered(direction: Direction, datagrams: int) -> None:
    """Wait until so many have come in."""
    async with asyncio.timeout(60):
        while direction.figures().entered < datagrams:  # noqa: ASYNC110 - sockets are what is waited for
            await asyncio.sleep(0)


async def test_both_directions() -> None:
    async with ImpairedPath() as path:
        with End() as one, End() as other:
            other.hears(path.to_viewer(one.candidate))
            one.hears(path.to_engine(other.candidate))
            one.send(b"down")
            assert await other.receive() == b"down"
            other.send(b"up")
            assert await one.receive() == b"up"
            assert one.other != other.other
            assert path.down.figures().delivered == path.up.figures().delivered == 1


async def test_hidden_end_is_known_by_its_first_datagram() -> None:
    async with ImpairedPath() as path:
        with End() as one, End() as hidden, End() as stranger:
            hidden.hears(path.to_viewer(one.candidate))
            one.hears(path.to_engine("candidate:1 1 udp 1 hidden.local 1 typ host"))
            one.send(b"lost")
            hidden.send(b"here I am")
            assert await one.receive() == b"here I am"
            stranger.other = hidden.other
            stranger.send(b"me too")
            hidden.send(b"again")
            assert await one.receive() == b"again"
            assert path.up.strangers == 1
            one.send(b"hello")
            assert await hidden.receive() == b"hello"


async def test_an_address_of_the_other_family_is_no_use() -> None:
    async with ImpairedPath() as path:
        with End() as one, End() as other:
            other.hears(path.to_viewer(CANDIDATE.format("fe80::1", 9)))
            one.hears(path.to_engine(other.candidate))
            one.send(b"by IPv4")
            assert await other.receive() == b"by IPv4"


async def test_the_later_ones_wait_and_a_change_counts_at_once() -> None:
    async with ImpairedPath(Impairments(rate=1000, queue=100)) as path:
        with End() as one, End() as other:
            other.hears(path.to_viewer(one.candidate))
            one.hears(path.to_engine(other.candidate))
            for _ in range(3):
                one.send(b"x" * 1000)
            await entered(path.down, 3)
            assert path.down.waiting > 3000
            path.down.change(rate=None)
            assert path.down.waiting == 0
            assert path.down.impairments == Impairments(queue=100)
            assert [len(await other.receive()) for _ in range(3)] == [1000] * 3
            path.down.lose_next(1)
            one.send(b"lost")
            one.send(b"found")
            assert await other.receive() == b"found"
            with pytest.raises(TypeError):
                path.down.change(colour="red")
            with pytest.raises(ValueError, match="loss"):
                path.down.change(loss=2)


async def test_closing_forgets_what_is_on_the_way() -> None:
    with End() as one, End() as other:
        async with ImpairedPath(Impairments(delay=3600)) as path:
            other.hears(path.to_viewer(one.candidate))
            one.hears(path.to_engine(other.candidate))
            one.send(b"late")
            await entered(path.down, 1)
        assert path.down.figures().delivered == 0


async def test_no_such_address() -> None:
    with pytest.raises(OSError, match="assign"):
        async with ImpairedPath(host="192.0.2.1"):
            pass
    with pytest.raises(ValueError, match="name"):
        async with ImpairedPath(host="name"):
            pass


@pytest.mark.media
async def test_all_media_of_a_viewer_passes_through_it() -> None:
    async with engine() as one, viewer(one) as seen, ImpairedPath() as path:
        seen.bend_offer, seen.bend_answer = path.to_viewer, path.to_engine
        one.connect("s1", "video")
        await seen.plays(frames=5)
        assert path.down.figures().delivered >= 5
        assert path.up.figures().delivered >= 1
        # Another section comes over the same sockets.
        one.connect("s2", "audio")
        await seen.plays("1", frames=5)
        assert one.failures == []
