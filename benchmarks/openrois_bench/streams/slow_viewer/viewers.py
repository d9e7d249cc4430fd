"""The viewers, and the bad network before the slow one; asked through pipes.

Run by `__main__` as `python -m openrois_bench.streams.slow_viewer.viewers`.
"""

import asyncio
from collections.abc import AsyncIterator, Mapping
from contextlib import AsyncExitStack, asynccontextmanager
from dataclasses import asdict
from typing import Any, Self

import numpy as np
from aiortc import MediaStreamTrack, RTCConfiguration, RTCPeerConnection, RTCSessionDescription
from aiortc.mediastreams import MediaStreamError
from aiortc.rtcconfiguration import RTCBundlePolicy
from openrois_streaming.clock import SystemClock
from openrois_streaming.source import stamp
from openrois_streaming.testing import ImpairedPath, Impairments, MeasuringSink
from openrois_streaming.testing.pictures import PictureFigures, PictureLog, SeenPicture

from openrois_bench.processes.partner import serve


class PlainSink:
    """A viewer of aiortc alone, which waits for the next picture before it shows one; its part of `MeasuringSink`."""

    def __init__(self, path: ImpairedPath | None) -> None:
        self._path = path
        self._clock = SystemClock()
        self._log = PictureLog(self._clock.now())
        self._connection = RTCPeerConnection(RTCConfiguration(iceServers=[], bundlePolicy=RTCBundlePolicy.MAX_BUNDLE))
        self._connection.on("track", self._watch)
        self._watching: asyncio.Task[None] | None = None

    async def __aenter__(self) -> Self:
        return self

    async def __aexit__(self, *_: object) -> None:
        """Close the peer connection."""
        await self._connection.close()
        if self._watching is not None:
            await self._watching

    async def answer(self, sdp: str) -> str:
        """The answer to the SDP of an offer."""
        offer = sdp if self._path is None else self._path.to_viewer(sdp)
        await self._connection.setRemoteDescription(RTCSessionDescription(offer, "offer"))
        await self._connection.setLocalDescription(await self._connection.createAnswer())
        answer: str = self._connection.localDescription.sdp
        return answer if self._path is None else self._path.to_engine(answer)

    def pictures(self) -> PictureFigures:
        """Return the figures of the pictures."""
        return self._log.figures(self._clock.now())

    def restart(self) -> None:
        """Begin to count anew."""
        self._log.restart(self._clock.now())

    def _watch(self, track: MediaStreamTrack) -> None:
        self._watching = asyncio.ensure_future(self._see(track))

    async def _see(self, track: MediaStreamTrack) -> None:
        while True:
            try:
                frame: Any = await track.recv()
            except MediaStreamError:
                return
            plane = frame.planes[0]
            rows = np.frombuffer(memoryview(plane), np.uint8).reshape(-1, plane.line_size)
            seen = stamp.read(rows[: frame.height, : frame.width])
            now, wall = self._clock.now(), self._clock.wall()
            self._log.add(SeenPicture(now, wall, frame.width, frame.height, seen))


@asynccontextmanager
async def _role() -> AsyncIterator[Mapping[str, Any]]:
    viewers: dict[str, tuple[AsyncExitStack, MeasuringSink | PlainSink]] = {}

    async def respond(params: dict[str, Any]) -> str:
        stack, path = AsyncExitStack(), None
        if params["down"] is not None:
            down, up = Impairments(**params["down"]), Impairments(**params["up"])
            path = await stack.enter_async_context(ImpairedPath(down, up, seed=params["seed"]))
        sink: MeasuringSink | PlainSink = MeasuringSink(path=path) if params["sink"] == "own" else PlainSink(path)
        await stack.enter_async_context(sink)
        viewers[params["viewer"]] = (stack, sink)
        return await sink.answer(params["sdp"])

    async def restart(_params: dict[str, Any]) -> None:
        for _, sink in viewers.values():
            sink.restart()

    async def read(_params: dict[str, Any]) -> dict[str, Any]:
        found: dict[str, Any] = {}
        for viewer, (_, sink) in viewers.items():
            seen = sink.pictures()
            found[viewer] = {**asdict(seen), "fps": seen.fps}
        return found

    async def leave(params: dict[str, Any]) -> None:
        stack, _ = viewers.pop(params["viewer"])
        await stack.aclose()

    yield {"respond": respond, "restart": restart, "read": read, "leave": leave}


if __name__ == "__main__":
    serve(_role)
