"""All receivers of a bench, in a process of their own: aiortc makes pictures of the packets, and none is decoded.

So they leave the machine to the sender, which is what is measured.
"""

import asyncio
import time
from collections.abc import AsyncIterator, Mapping
from contextlib import AsyncExitStack, asynccontextmanager
from typing import Any, Protocol, cast

import aiortc.rtcrtpreceiver
from aiortc import MediaStreamTrack, RTCConfiguration, RTCPeerConnection, RTCSessionDescription
from aiortc.mediastreams import MediaStreamError
from aiortc.rtcconfiguration import RTCBundlePolicy

from openrois.jsonrpc.session import Handler
from openrois_bench.processes.partner import cpu_seconds, serve

__all__ = ["Receivers"]


class _Encoded(Protocol):
    """A picture as aiortc hands it to a decoder."""

    data: bytes


class _NoDecoder:
    """Stands in for aiortc's decoders: the track gets the encoded pictures themselves."""

    def decode(self, encoded: _Encoded) -> list[_Encoded]:
        return [encoded]


class _Receiver:
    """One viewer: what it got so far."""

    def __init__(self, connection: RTCPeerConnection) -> None:
        self.pictures = 0
        self.received = 0
        self.connected = asyncio.Event()
        connection.on("connectionstatechange", lambda: self._state(connection.connectionState))

    def _state(self, state: str) -> None:
        if state == "connected":
            self.connected.set()

    async def count(self, track: MediaStreamTrack) -> None:
        try:
            while True:
                self.received += len(cast(_Encoded, await track.recv()).data)
                self.pictures += 1
        except MediaStreamError:
            return


class Receivers:
    """The receivers of all senders, by the sender's name."""

    def __init__(self, tasks: asyncio.TaskGroup, stack: AsyncExitStack) -> None:
        self._tasks = tasks
        self._stack = stack
        self._receivers: dict[str, list[_Receiver]] = {}

    async def answer_offer(self, sender: str, sdp: str) -> str:
        """Make one more receiver for an offer of `sender`; returns the SDP of its answer."""
        connection = RTCPeerConnection(RTCConfiguration(iceServers=[], bundlePolicy=RTCBundlePolicy.MAX_BUNDLE))
        self._stack.push_async_callback(connection.close)
        receiver = _Receiver(connection)
        await connection.setRemoteDescription(RTCSessionDescription(sdp, "offer"))
        await connection.setLocalDescription(await connection.createAnswer())
        self._tasks.create_task(receiver.count(connection.getReceivers()[0].track))
        self._receivers.setdefault(sender, []).append(receiver)
        return connection.localDescription.sdp

    def read(self, sender: str) -> dict[str, Any]:
        """Return the counts of each receiver of `sender`, the cost of all to this process, and the time of reading."""
        receivers = self._receivers[sender]
        return {
            "at": time.monotonic(),
            "cpu": cpu_seconds(),
            "pictures": [receiver.pictures for receiver in receivers],
            "bytes": [receiver.received for receiver in receivers],
        }

    async def connected(self, sender: str) -> None:
        """Wait until media can come to all receivers of `sender`."""
        for receiver in self._receivers[sender]:
            await receiver.connected.wait()


@asynccontextmanager
async def _role() -> AsyncIterator[Mapping[str, Handler]]:
    vars(aiortc.rtcrtpreceiver)["get_decoder"] = lambda _codec: _NoDecoder()
    async with asyncio.TaskGroup() as tasks, AsyncExitStack() as stack:
        receivers = Receivers(tasks, stack)

        async def answer(params: dict[str, Any]) -> str:
            return await receivers.answer_offer(params["sender"], params["sdp"])

        async def connected(params: dict[str, Any]) -> None:
            await receivers.connected(params["sender"])

        async def read(params: dict[str, Any]) -> dict[str, Any]:
            return receivers.read(params["sender"])

        yield {"answer": answer, "connected": connected, "read": read}


if __name__ == "__main__":
    serve(_role)
