"""Viewers of a bench, a process of their own: one that only watches, many that join and leave, and one that floods.

Packets are counted and not decoded, so that the machine is left to what is measured.
"""

import asyncio
import os
import socket
import struct
import time
from collections.abc import AsyncIterator, Callable, Mapping
from contextlib import AsyncExitStack, asynccontextmanager, suppress
from functools import partial
from typing import Any, Final

from aiortc import RTCConfiguration, RTCPeerConnection, RTCSessionDescription
from aiortc.rtcconfiguration import RTCBundlePolicy
from aiortc.rtp import RTCP_RTPFB_NACK, RtcpRtpfbPacket, RtpPacket
from openrois_streaming.aiortc_internals.srtp import Protection
from openrois_streaming.codecs import H264
from openrois_streaming.testing.candidates import addresses

from openrois.jsonrpc.session import Handler
from openrois_bench.errors import BenchFailed, within
from openrois_bench.processes.partner import serve
from openrois_bench.viewing.application import Application, application

__all__ = ["Guest", "guest", "paced"]

_PATIENCE: Final = 15.0
_TICK: Final = 0.001
_CATCH_UP: Final = 0.02
"""Seconds' worth of datagrams that are sent at once at most; a longer delay of this process is not made up for."""

_LEAVE_OUT: Final = 0.9
"""Share of the time in which viewers join, so that the last of them see something before it is over."""

_MISSED: Final = 17
"""Packets that a NACK asks for again: as many as one entry names (RFC 4585 section 6.2.1)."""


class Guest:
    """Viewer that plays one video stream.

    Attributes:
        packets: of RTP that came.
        pictures: whose last packet came.
        targets: the addresses and ports by which the engine can be reached.
    """

    def __init__(self, app: Application) -> None:
        self.packets = self.pictures = 0
        self.targets: list[tuple[str, int]] = []
        self._app = app
        self._ssrc = self._sequence = 0
        self._arrived = asyncio.Event()
        self.connection = RTCPeerConnection(RTCConfiguration(iceServers=[], bundlePolicy=RTCBundlePolicy.MAX_BUNDLE))

    @property
    def bye(self) -> str:
        """The reason for which the engine has ended its peer connection; empty if it has not."""
        return self._app.bye

    async def join(self, component_ref: str) -> None:
        """Play the stream of a component; returns when the first packet is there.

        Raises:
            BenchFailed: it is refused, or nothing comes.
        """
        _, offer = await self._app.offered(component_ref, H264)
        self.targets = addresses(offer["sdp"])
        await self.connection.setRemoteDescription(RTCSessionDescription(offer["sdp"], "offer"))
        receiver: Any = self.connection.getReceivers()[0]
        receiver._handle_rtp_packet = self._count
        await self.connection.setLocalDescription(await self.connection.createAnswer())
        await self._app.answer_offer(offer, self.connection.localDescription.sdp)
        async with within(_PATIENCE, "the first packet"):
            await self._arrived.wait()

    async def _count(self, packet: RtpPacket, arrival_time_ms: int) -> None:
        self.packets += 1
        self.pictures += packet.marker
        self._ssrc, self._sequence = packet.ssrc, packet.sequence_number
        self._arrived.set()

    def complain(self) -> Callable[[int], None]:
        """Return what sends so many authentic reports that ask for the newest packets again."""
        dtls = self.connection.getReceivers()[0].transport
        pair = dtls.transport._connection._nominated[1]
        protection, transport, target = Protection(dtls._tx_srtp), pair.protocol.transport, pair.remote_addr

        def send(number: int) -> None:
            lost = [(self._sequence - behind) % 2**16 for behind in range(_MISSED, 0, -1)]
            report = bytes(RtcpRtpfbPacket(fmt=RTCP_RTPFB_NACK, ssrc=1, media_ssrc=self._ssrc, lost=lost))
            for _ in range(number):
                transport.sendto(protection.rtcp(report), target)

        return send


@asynccontextmanager
async def guest(url: str) -> AsyncIterator[Guest]:
    """Connect to the gateway as a viewer that has no stream yet, for as long as the context lasts."""
    async with application(url) as app:
        viewer = Guest(app)
        try:
            yield viewer
        finally:
            await viewer.connection.close()


async def paced(rate: float, seconds: float, send: Callable[[int], None]) -> int:
    """Have `send` send `rate` a second, evenly; returns how many were sent."""
    began = counted = time.monotonic()
    due, sent = 0.0, 0
    while (now := time.monotonic()) - began < seconds:
        due = min(due + (now - counted) * rate, rate * _CATCH_UP)
        counted = now
        if number := int(due):
            send(number)
            sent += number
            due -= number
        await asyncio.sleep(_TICK)
    return sent


class _Complaining:
    """Floods with reports over one peer connection after the other: the engine ends those that flood."""

    def __init__(self, url: str, component_ref: str, stack: AsyncExitStack) -> None:
        self.sent = self.used = 0
        self._url = url
        self._component_ref = component_ref
        self._stack = stack

    async def flood(self, rate: float, seconds: float) -> None:
        """Send reports for so long; the next peer connection is there before it is needed."""
        end = time.monotonic() + seconds
        spare = asyncio.ensure_future(self._joined())
        try:
            while (left := end - time.monotonic()) > 0:
                viewer = await spare
                self.used += 1
                spare = asyncio.ensure_future(self._joined())
                with suppress(_Ended):
                    await paced(rate, left, partial(self._send, viewer, viewer.complain()))
        finally:
            spare.cancel()
            await asyncio.gather(spare, return_exceptions=True)

    async def _joined(self) -> Guest:
        viewer = await self._stack.enter_async_context(guest(self._url))
        await viewer.join(self._component_ref)
        return viewer

    def _send(self, viewer: Guest, send: Callable[[int], None], number: int) -> None:
        if viewer.bye:
            raise _Ended
        send(number)
        self.sent += number


class _Ended(Exception):
    """The engine has ended a peer connection."""


async def _strangers(targets: list[tuple[str, int]], rate: float, seconds: float) -> int:
    """Flood the addresses of a peer connection with junk SRTP and with STUN that proves nothing, in turn."""
    sockets = {family: socket.socket(family, socket.SOCK_DGRAM) for family in (socket.AF_INET, socket.AF_INET6)}
    for each in sockets.values():
        each.setblocking(False)
    ways = [(sockets[socket.AF_INET6 if ":" in host else socket.AF_INET], (host, port)) for host, port in targets]
    media = b"\x80\x60" + os.urandom(998)
    check = struct.pack("!HHL12s", 1, 20, 0x2112A442, bytes(12)) + struct.pack("!HH13s3x", 6, 13, b"0000:stranger")
    turn = 0

    def send(number: int) -> None:
        nonlocal turn
        for _ in range(number):
            turn += 1
            way, target = ways[turn // 2 % len(ways)]
            with suppress(BlockingIOError):
                way.sendto(check if turn % 2 else media, target)

    try:
        return await paced(rate, seconds, send)
    finally:
        for each in sockets.values():
            each.close()


async def _joining(url: str, component_ref: str, viewers: int, seconds: float) -> tuple[int, int]:
    """Have viewers join, evenly over the time, and leave when they see something; returns how many did and did not."""
    outcomes: list[bool] = []

    async def visit() -> None:
        try:
            async with guest(url) as viewer:
                await viewer.join(component_ref)
            outcomes.append(True)
        except (BenchFailed, OSError, TimeoutError):
            outcomes.append(False)

    pause = _LEAVE_OUT * seconds / max(viewers, 1)
    async with asyncio.TaskGroup() as tasks:
        for _ in range(viewers):
            tasks.create_task(visit())
            await asyncio.sleep(pause)
    return sum(outcomes), len(outcomes) - sum(outcomes)


async def _harass(params: dict[str, Any]) -> Mapping[str, Any]:
    """Do all that is asked for, at the same time; returns what of it was done."""
    url, ref, seconds = params["url"], params["component_ref"], params["seconds"]
    targets = [(host, port) for host, port in params["targets"]]
    began = time.monotonic()
    async with AsyncExitStack() as stack, asyncio.TaskGroup() as tasks:
        complaining = _Complaining(url, ref, stack)
        strangers = tasks.create_task(_strangers(targets, params["strangers"], seconds))
        joining = tasks.create_task(_joining(url, ref, params["viewers"], seconds))
        if params["reports"]:
            tasks.create_task(complaining.flood(params["reports"], seconds))
    took = max(time.monotonic() - began, seconds)
    joined, failed = joining.result()
    return {
        "reports": complaining.sent / took,
        "peers": complaining.used,
        "strangers": strangers.result() / took,
        "joined": joined,
        "failed": failed,
    }


@asynccontextmanager
async def _role() -> AsyncIterator[Mapping[str, Handler]]:
    async with AsyncExitStack() as stack:
        watching: list[Guest] = []

        async def watch(params: dict[str, Any]) -> Mapping[str, Any]:
            viewer = await stack.enter_async_context(guest(params["url"]))
            await viewer.join(params["component_ref"])
            watching.append(viewer)
            return {"targets": viewer.targets}

        async def seen(_params: dict[str, Any]) -> Mapping[str, Any]:
            return {"pictures": watching[0].pictures, "at": time.monotonic(), "bye": watching[0].bye}

        yield {"watch": watch, "seen": seen, "harass": _harass}


if __name__ == "__main__":
    serve(_role)
