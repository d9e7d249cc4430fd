"""Bad network between an engine and one viewer: two sockets that relay all of their media.

Candidates are rewritten, so that either end knows only the address of the path::

    async with ImpairedPath(down=Impairments(rate=1_000_000, delay=0.02)) as path:
        answer = await viewer.answer(path.to_viewer(offer))
        await session.apply_answer(path.to_engine(answer))
        ...
        path.down.change(loss=0.05)
"""

import asyncio
import ipaddress
import socket
from contextlib import AsyncExitStack
from dataclasses import replace
from typing import Any, Self

from openrois_streaming.testing.candidates import Address, addresses, rerouted
from openrois_streaming.testing.link import Impairments, Link, LinkFigures

_BUFFER = 1 << 22
"""Bytes that a socket keeps while the loop is busy, so that only the link loses datagrams."""


class _Face(asyncio.DatagramProtocol):
    """Socket that represents the other end to one end."""

    def __init__(self) -> None:
        self.end: Address | None = None
        """Address of that end; None until its candidates or first datagram."""
        self.strangers = 0
        self.address: Address = ("", 0)
        self._transport: asyncio.DatagramTransport | None = None
        self._direction: Direction | None = None

    async def open(self, host: str, direction: "Direction") -> None:
        self._direction = direction
        family = socket.AF_INET6 if ipaddress.ip_address(host).version == 6 else socket.AF_INET
        one = socket.socket(family, socket.SOCK_DGRAM)
        try:
            one.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, _BUFFER)
            one.bind((host, 0))
            one.setblocking(False)
            self.address = (host, one.getsockname()[1])
            self._transport, _ = await asyncio.get_running_loop().create_datagram_endpoint(lambda: self, sock=one)
        except BaseException:
            one.close()
            raise

    def expect(self, text: str) -> None:
        """Set the end's address by its own candidates, if it is not known yet."""
        if self.end is None:
            version = ipaddress.ip_address(self.address[0]).version
            usable = (each for each in addresses(text) if ipaddress.ip_address(each[0]).version == version)
            self.end = next(usable, None)

    def datagram_received(self, data: bytes, addr: tuple[Any, ...]) -> None:
        """Receive a datagram of the end. A browser that hides its addresses is known by its first one."""
        if self.end is None:
            self.end = addr[:2]
        if addr[:2] != self.end:
            self.strangers += 1
        elif self._direction is not None:
            self._direction.push(data)

    def send(self, data: bytes) -> None:
        if self._transport is not None and self.end is not None:
            self._transport.sendto(data, self.end)

    def close(self) -> None:
        self._direction = None
        if self._transport is not None:
            self._transport.close()


class Direction:
    """Direction of a path."""

    def __init__(self, link: Link, source: _Face, target: _Face) -> None:
        self._link = link
        self._source = source
        self._target = target
        self._timer: asyncio.TimerHandle | None = None

    @property
    def impairments(self) -> Impairments:
        """Present impairments."""
        return self._link.impairments

    @property
    def waiting(self) -> int:
        """Bytes that wait at its bottleneck."""
        return self._link.waiting

    @property
    def strangers(self) -> int:
        """Datagrams from other addresses than the end's; they were dropped."""
        return self._source.strangers

    def figures(self) -> LinkFigures:
        """Return the counts so far."""
        return self._link.figures()

    def change(self, **changes: Any) -> None:
        """Change some of its impairments, by the names of `Impairments`, from now on.

        Raises:
            TypeError: there is no such impairment.
            ValueError: a value is out of range.
        """
        self._link.change(replace(self._link.impairments, **changes), self._now())
        self._pump()

    def lose_next(self, datagrams: int) -> None:
        """Lose so many datagrams in a row."""
        self._link.lose_next(datagrams)

    def push(self, datagram: bytes) -> None:
        """Add a datagram of the end."""
        self._link.push(datagram, self._now())
        self._pump()

    def close(self) -> None:
        """Drop all datagrams on the way."""
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None

    def _now(self) -> float:
        return asyncio.get_running_loop().time()

    def _pump(self) -> None:
        for datagram in self._link.pop(self._now()):
            self._target.send(datagram)
        self.close()
        due = self._link.next_at
        if due is not None:
            self._timer = asyncio.get_running_loop().call_at(due, self._pump)


class ImpairedPath:
    """Network path between an engine and one viewer, for one peer connection that bundles its sections.

    Each end is known by its best usable UDP candidate, or else by its first datagram; datagrams from other addresses
    are dropped. Delays keep to the loop's timers, which are late by up to 1 ms.

    Args:
        down: impairments of datagrams of the engine.
        up: impairments of datagrams of the viewer.
        host: the IP address of this machine by which both ends can reach it.
        seed: the same seed loses, delays and doubles the same again.

    Attributes:
        down: from the engine to the viewer.
        up: from the viewer to the engine.
    """

    def __init__(
        self,
        down: Impairments | None = None,
        up: Impairments | None = None,
        *,
        host: str = "127.0.0.1",
        seed: int = 0,
    ) -> None:
        self._host = host
        self._engine, self._viewer = _Face(), _Face()
        self.down = Direction(Link(down, seed=seed), self._engine, self._viewer)
        self.up = Direction(Link(up, seed=seed + 1), self._viewer, self._engine)
        self._opened = AsyncExitStack()

    async def __aenter__(self) -> Self:
        """Open the sockets.

        Raises:
            OSError: this machine has no such address.
            ValueError: `host` is no address.
        """
        async with AsyncExitStack() as stack:
            for face, direction in ((self._engine, self.down), (self._viewer, self.up)):
                stack.callback(direction.close)
                stack.callback(face.close)
                await face.open(self._host, direction)
            self._opened = stack.pop_all()
        return self

    async def __aexit__(self, *_: object) -> None:
        """Close the sockets; datagrams on the way are lost."""
        await self._opened.aclose()

    def to_viewer(self, text: str) -> str:
        """Return a text of the engine with rewritten candidates for the viewer: an SDP, a candidate, or a message."""
        self._engine.expect(text)
        return rerouted(text, self._viewer.address)

    def to_engine(self, text: str) -> str:
        """Return a text of the viewer with rewritten candidates for the engine."""
        self._viewer.expect(text)
        return rerouted(text, self._engine.address)
