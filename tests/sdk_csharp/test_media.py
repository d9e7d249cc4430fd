"""Streams of an application in C#: it negotiates, and a WebRTC library elsewhere is its `IMediaPeer`."""

import asyncio
from contextlib import suppress
from types import TracebackType
from typing import Any, Self

import pytest
from aiortc import MediaStreamTrack, RTCPeerConnection, RTCSessionDescription
from aiortc.mediastreams import MediaStreamError
from aiortc.sdp import candidate_from_sdp

from tests.sdk_csharp.conftest import Start
from tests.support.json_program import JsonProgram
from tests.support.loopback import PATIENCE
from tests.support.media_body import body

pytestmark = [pytest.mark.media, pytest.mark.timeout(120)]


async def add(peer: RTCPeerConnection, told: str | None) -> None:
    """Add a candidate of the engine, which says it as `RTCIceCandidate.candidate` has it."""
    if told:
        candidate = candidate_from_sdp(told.removeprefix("candidate:"))
        candidate.sdpMLineIndex = 0
        await peer.addIceCandidate(candidate)


async def until_status(app: JsonProgram, peer: RTCPeerConnection, wanted: str) -> None:
    """Read what the application says until a stream has this status."""
    while (said := await app.says_something()) != ("status", wanted):
        if said[0] == "candidate":
            await add(peer, said[1])


class Pictures:
    """The pictures of a peer connection."""

    def __init__(self, peer: RTCPeerConnection) -> None:
        self._frames: asyncio.Queue[object] = asyncio.Queue()
        self._tasks = asyncio.TaskGroup()
        peer.on("track", self._begin)

    async def __aenter__(self) -> Self:
        await self._tasks.__aenter__()
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        await self._tasks.__aexit__(kind, error, trace)

    async def wait(self, count: int) -> None:
        """Wait until so many more have come."""
        async with asyncio.timeout(PATIENCE):
            for _ in range(count):
                await self._frames.get()

    def _begin(self, track: MediaStreamTrack) -> None:
        self._tasks.create_task(self._read(track))

    async def _read(self, track: MediaStreamTrack) -> None:
        with suppress(MediaStreamError):
            while True:
                self._frames.put_nowait(await track.recv())


async def test_pictures_arrive_where_an_application_in_csharp_negotiates(start: Start) -> None:
    peer = RTCPeerConnection()
    async with body() as robot, Pictures(peer) as pictures, start("viewer", robot.url) as app:
        said: dict[str, Any] = {}
        while not {"offer", "stream"} <= said.keys():
            said |= [await app.says_something()]
        sdp, carried = said["offer"]
        assert carried == said["stream"]
        await peer.setRemoteDescription(RTCSessionDescription(sdp, "offer"))
        await peer.setLocalDescription(await peer.createAnswer())
        await app.go_on(peer.localDescription.sdp.replace("\r\n", "|"))
        await until_status(app, peer, "StreamingRunning")
        await pictures.wait(3)
        await app.go_on()
        await until_status(app, peer, "StreamingNotConnected")
        await app.ends()
        await peer.close()
