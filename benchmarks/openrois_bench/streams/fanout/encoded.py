"""Cost of a further viewer to a process that sends pre-encoded frames.

`python -m openrois_bench.streams.fanout.encoded --json FILE`. One rendition of H.264 (30 frames a second, 2.5 Mbit/s,
random bytes of varying length, made before) goes to 1 and to N viewers: by this package, with all of a session around
it, and by aiortc with tracks that yield the same frames as `av.Packet`s. Viewers are peer connections of aiortc in
another process, which drop RTP as it arrives and report once a second, as browsers do, that it came. Counted is the CPU
time of the sending process, kernel included; on loopback that holds the work of receiving, too. The marginal cost is
the difference between N viewers and 1, divided by N - 1. Runs of both kinds take turns. A sender that does not keep up
sends less than it should and looks cheaper than it is.
"""

import argparse
import asyncio
import contextlib
import itertools
import json
import os
import re
import resource
import subprocess
import sys
import time
from collections.abc import AsyncIterator, Awaitable, Callable, Hashable
from contextlib import asynccontextmanager
from fractions import Fraction
from pathlib import Path
from typing import Any

import aioice.ice
import av
import numpy as np
import uvloop
from aiortc import (
    MediaStreamTrack,
    RTCConfiguration,
    RTCPeerConnection,
    RTCRtpSender,
    RTCSessionDescription,
)
from aiortc.rtcconfiguration import RTCBundlePolicy
from aiortc.rtp import RtcpReceiverInfo, RtcpRrPacket
from openrois_signaling.messages import Answer, Offer
from openrois_streaming.clock import SystemClock
from openrois_streaming.encoded import EncodedFrame
from openrois_streaming.publish.key_frames import KeyFrameCause
from openrois_streaming.publish.rendition import DirectMailbox
from openrois_streaming.rtp.payloads import payloads_of
from openrois_streaming.session.session import StreamSession
from openrois_streaming.source.fanout import DropOldest, Fanout, Subscription
from openrois_streaming.state import StreamStatus

from openrois_bench.measuring.conditions import conditions, load
from openrois_bench.measuring.figures import medians
from openrois_bench.measuring.result import write_result

FRAME_RATE, BITRATE = 30, 2_500_000
WARM_UP = 2.0
CONFIGURATION = RTCConfiguration(iceServers=[], bundlePolicy=RTCBundlePolicy.MAX_BUNDLE)
LINE_LIMIT = 1 << 20
SSRC = re.compile(r"a=ssrc:(\d+) ")

Answering = Callable[[int, str], Awaitable[str]]
"""Gives the answer of a viewer to an offer."""


class Frames:
    """The frames of a second, over and over; the time of each is its own."""

    def __init__(self) -> None:
        chance = np.random.default_rng(1)
        lengths = chance.uniform(0.6, 1.4, FRAME_RATE) * BITRATE / 8 / FRAME_RATE
        self._data = [
            b"\0\0\0\1\x65" + chance.integers(1, 256, round(length), np.uint8).tobytes() for length in lengths
        ]

    @asynccontextmanager
    async def open(self) -> AsyncIterator[AsyncIterator[EncodedFrame]]:
        """Begin."""
        yield self._paced()

    async def _paced(self) -> AsyncIterator[EncodedFrame]:
        clock = SystemClock()
        began = clock.now()
        for number in itertools.count():
            moment = began + number / FRAME_RATE
            await clock.sleep_until(moment)
            data = self._data[number % len(self._data)]
            yield EncodedFrame(
                data, payloads_of("video/H264", data), round(moment * 90_000), 90_000, True, number, moment
            )


class Published:
    """A publisher and its only rendition."""

    def __init__(self) -> None:
        self.frames: Fanout[EncodedFrame] = Fanout(Frames(), name="frames")

    def renditions(self, mime_type: str, fps: float | None = None) -> "tuple[Published]":
        """The only one."""
        return (self,)

    def has_room(self, mime_type: str) -> bool:
        """Always true."""
        return True

    def can_encode(self, mime_type: str) -> bool:
        """Always true: there is no encoder."""
        return True

    @property
    def rung(self) -> None:
        """There is nothing to choose."""

    @asynccontextmanager
    async def play(
        self, viewer: Hashable, on_frame: Callable[[EncodedFrame], None], bitrate: float | None = None
    ) -> AsyncIterator[Subscription[EncodedFrame]]:
        """Have `on_frame` called with each frame."""
        async with self.frames.subscribe(mailbox=DirectMailbox(on_frame)) as subscription:
            yield subscription

    def prepare(self) -> contextlib.AbstractAsyncContextManager[None]:
        """The frames are there already."""
        return contextlib.nullcontext()

    def wanted(self) -> contextlib.AbstractContextManager[None]:
        """It never fails."""
        return contextlib.nullcontext()

    def demand(self, viewer: Hashable, bitrate: float) -> None:
        """The frames stay as they are."""

    def least(self, viewer: Hashable) -> float:
        """Return 0: every viewer may play it."""
        return 0.0

    def request_key_frame(self, cause: KeyFrameCause) -> None:
        """Every frame is one."""


async def send_with_ours(stack: contextlib.AsyncExitStack, number: int, published: Published, ask: Answering) -> None:
    """Connect one viewer by a session, and wait until it plays."""
    tasks: set[asyncio.Task[None]] = set()

    async def apply_answer(offer: Offer) -> None:
        sdp = await ask(number, offer.sdp)
        await session.apply_answer(Answer(peer_id=offer.peer_id, generation=offer.generation, sdp=sdp))

    def say(message: Any) -> None:
        if isinstance(message, Offer):
            tasks.add(asyncio.create_task(apply_answer(message)))

    session = await stack.enter_async_context(
        StreamSession(mint=lambda: f"p{number}", send=say, on_change=lambda change: None, clock=SystemClock())
    )
    session.connect(f"s{number}", "engine/Video", published, "video", ["H264"])
    while (await session.stats(f"s{number}")).frames_sent == 0:  # noqa: ASYNC110 - there is no notification of it
        await asyncio.sleep(0.05)
    assert session.status(f"s{number}") is not StreamStatus.NOT_CONNECTED


class PacketTrack(MediaStreamTrack):
    """Track of packets that aiortc sends without encoding them."""

    kind = "video"

    def __init__(self, frames: Subscription[EncodedFrame]) -> None:
        super().__init__()
        self._frames = frames
        self.sent = 0

    async def recv(self) -> Any:
        """The next frame."""
        frame = await self._frames.get()
        packet: Any = av.Packet(frame.data)
        packet.pts = packet.dts = frame.pts
        packet.time_base = Fraction(1, frame.clock_rate)
        packet.is_keyframe = True
        self.sent += 1
        return packet


async def send_with_aiortc(stack: contextlib.AsyncExitStack, number: int, published: Published, ask: Answering) -> None:
    """Connect one viewer by a peer connection of aiortc, and wait until it plays."""
    track = PacketTrack(await stack.enter_async_context(published.frames.subscribe(mailbox=DropOldest(8))))
    connection = RTCPeerConnection(CONFIGURATION)
    stack.push_async_callback(connection.close)
    transceiver = connection.addTransceiver(track, direction="sendonly")
    known = RTCRtpSender.getCapabilities("video").codecs
    transceiver.setCodecPreferences([each for each in known if each.mimeType in ("video/H264", "video/rtx")])
    await connection.setLocalDescription(await connection.createOffer())
    sdp = await ask(number, connection.localDescription.sdp)
    await connection.setRemoteDescription(RTCSessionDescription(sdp, "answer"))
    while track.sent == 0:  # noqa: ASYNC110 - there is no notification of it
        await asyncio.sleep(0.05)


SENDERS = {"ours": send_with_ours, "aiortc": send_with_aiortc}


async def measure(kind: str, viewers: int, seconds: float) -> dict[str, Any]:
    """CPU seconds per second of this process while it sends to so many viewers."""
    receivers = await asyncio.create_subprocess_exec(
        sys.executable,
        "-m",
        "openrois_bench.streams.fanout.encoded",
        "--receivers",
        stdin=asyncio.subprocess.PIPE,
        stdout=asyncio.subprocess.PIPE,
        limit=LINE_LIMIT,
    )
    assert receivers.stdin is not None
    assert receivers.stdout is not None

    async def send_line(**message: Any) -> Any:
        receivers.stdin.write(json.dumps(message).encode() + b"\n")  # type: ignore[union-attr]
        return json.loads(await receivers.stdout.readline())  # type: ignore[union-attr]

    async def ask(number: int, sdp: str) -> str:
        return str((await send_line(number=number, sdp=sdp))["sdp"])

    published = Published()
    async with contextlib.AsyncExitStack() as stack:
        for number in range(viewers):
            await SENDERS[kind](stack, number, published, ask)
        await asyncio.sleep(WARM_UP)
        before, count, began = cpu(), await send_line(count=True), time.monotonic()
        await asyncio.sleep(seconds)
        passed = time.monotonic() - began
        used, arrived = cpu() - before, await send_line(count=True)
    receivers.stdin.close()
    await receivers.wait()
    return {
        "kind": kind,
        "viewers": viewers,
        "cpu": used / passed,
        "packets_per_viewer": (arrived["packets"] - count["packets"]) / passed / viewers,
        "kbits_per_viewer": (arrived["octets"] - count["octets"]) * 8 / 1000 / passed / viewers,
        "load": os.getloadavg()[0],
    }


def cpu() -> float:
    """CPU seconds of this process so far."""
    usage = resource.getrusage(resource.RUSAGE_SELF)
    return usage.ru_utime + usage.ru_stime


async def receive() -> None:
    """Be the viewers: answer offers, count what comes and drop it."""
    packets = octets = 0
    received = aioice.ice.StunProtocol.datagram_received

    def count(self: aioice.ice.StunProtocol, data: Any, addr: Any) -> None:
        nonlocal packets, octets
        if 128 <= data[0] < 192 and not 192 <= data[1] <= 208:
            packets += 1
            octets += len(data)
        else:
            received(self, data, addr)

    aioice.ice.StunProtocol.datagram_received = count  # type: ignore[method-assign]
    reader = asyncio.StreamReader(limit=LINE_LIMIT)
    await asyncio.get_running_loop().connect_read_pipe(lambda: asyncio.StreamReaderProtocol(reader), sys.stdin)
    connections: list[RTCPeerConnection] = []
    reports: set[asyncio.Task[None]] = set()
    while line := await reader.readline():
        message = json.loads(line)
        if "count" in message:
            print(json.dumps({"packets": packets, "octets": octets}), flush=True)
            continue
        connection = RTCPeerConnection(CONFIGURATION)
        connections.append(connection)
        await connection.setRemoteDescription(RTCSessionDescription(message["sdp"], "offer"))
        await connection.setLocalDescription(await connection.createAnswer())
        reports.add(asyncio.create_task(keep_reporting(connection, int(SSRC.findall(message["sdp"])[0]))))
        print(json.dumps({"sdp": connection.localDescription.sdp}), flush=True)
    for task in reports:
        task.cancel()
    await asyncio.gather(*(connection.close() for connection in connections))


async def keep_reporting(connection: RTCPeerConnection, ssrc: int) -> None:
    """Say once a second that the packets of `ssrc` come."""
    transport = connection.getTransceivers()[0].receiver.transport
    for number in itertools.count():
        await asyncio.sleep(1)
        about = RtcpReceiverInfo(
            ssrc=ssrc, fraction_lost=0, packets_lost=0, highest_sequence=number, jitter=0, lsr=0, dlsr=0
        )
        with contextlib.suppress(ConnectionError):
            await transport._send_rtp(bytes(RtcpRrPacket(ssrc=1, reports=[about])))


def one_run(kind: str, viewers: int, seconds: float, loop: str) -> dict[str, Any]:
    """Measure in a process of its own, so that one run leaves nothing to the next."""
    command = [
        sys.executable,
        "-m",
        "openrois_bench.streams.fanout.encoded",
        "--run",
        kind,
        "--viewers",
        str(viewers),
        "--seconds",
        str(seconds),
    ]
    command += ["--loop", loop]
    done = subprocess.run(command, check=True, capture_output=True, text=True, timeout=120)
    return dict(json.loads(done.stdout.splitlines()[-1]))


def main() -> None:
    """Measure, or be a part of a measurement."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--json", type=Path, help="where the medians go")
    parser.add_argument("--viewers", type=int, default=16, help="N")
    parser.add_argument("--seconds", type=float, default=5.0, help="of each run")
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--loop", choices=("asyncio", "uvloop"), default="asyncio")
    parser.add_argument("--run", choices=sorted(SENDERS), help=argparse.SUPPRESS)
    parser.add_argument("--receivers", action="store_true", help=argparse.SUPPRESS)
    options = parser.parse_args()
    factory = uvloop.new_event_loop if options.loop == "uvloop" else asyncio.new_event_loop
    if options.receivers:
        asyncio.run(receive())
    elif options.run:
        with asyncio.Runner(loop_factory=factory) as runner:
            print(json.dumps(runner.run(measure(options.run, options.viewers, options.seconds))))
    else:
        report(options)


def report(options: argparse.Namespace) -> None:
    """Take turns, and say what came of it."""
    before, runs = load(), []
    for _, kind, viewers in itertools.product(range(options.repeats), SENDERS, (1, options.viewers)):
        run = one_run(kind, viewers, options.seconds, options.loop)
        runs.append(run)
        print(
            f"{kind:7} N={viewers:<3} {run['cpu']:.3f} cores, {run['packets_per_viewer']:.0f} packets/s and "
            f"{run['kbits_per_viewer']:.0f} kbit/s a viewer, load {run['load']:.1f}",
            flush=True,
        )
    rows = medians(runs, by=("kind", "viewers"), of=("cpu", "packets_per_viewer", "kbits_per_viewer", "load"))
    cpu = {(row["kind"], row["viewers"]): row["cpu"] for row in rows}
    marginal = {kind: (cpu[kind, options.viewers] - cpu[kind, 1]) / (options.viewers - 1) for kind in SENDERS}
    ratio = marginal["ours"] / marginal["aiortc"]
    print(
        f"a further viewer: ours {marginal['ours'] * 1000:.2f}, aiortc {marginal['aiortc'] * 1000:.2f} thousandths "
        f"of a core; ratio {ratio:.2f}"
    )
    write_result(
        options.json,
        "openrois_bench.streams.fanout.encoded",
        conditions(before),
        summary=rows,
        marginal=marginal,
        ratio=ratio,
    )


if __name__ == "__main__":
    main()
