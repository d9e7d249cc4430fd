"""A viewer: it answers offers, counts decoded frames, and is checked by the invariants.

It receives with the product's own receiver, which repairs losses as a browser does and aiortc's does not.
"""

import asyncio
import json
import socket
import sys
import time
from collections.abc import Awaitable, Callable
from contextlib import suppress
from typing import Any, Final

from aiortc import MediaStreamTrack, RTCConfiguration, RTCIceServer, RTCPeerConnection, RTCSessionDescription
from aiortc.rtcconfiguration import RTCBundlePolicy
from aiortc.sdp import candidate_from_sdp
from openrois_streaming.aiortc_internals.ice_checks import stop_consent_when_closed
from openrois_streaming.clock import SystemClock
from openrois_streaming.peer.receiver import RtpReceiver
from openrois_streaming.receive.remote_time import RemoteClock
from openrois_streaming.source.source import MediaSource, RawAudio, RawVideo
from openrois_streaming.testing import ImpairedPath
from websockets.asyncio.client import ClientConnection

from tests.support.invariants import Book, Witness

__all__ = ["AUDIO", "MEDIA_PATIENCE", "VIDEO", "Spectator"]

VIDEO: Final = "avatar/video_streaming"
AUDIO: Final = "avatar/audio_streaming"
MEDIA_PATIENCE: Final = 80.0
"""Seconds that anything of media may take on a busy machine."""


class Spectator(Witness):
    """Plays streams of the avatar.

    Attributes:
        devices: what it sends in streams of a kind, where it is to send.
        relays: what its next peer connections may pass, as the gateway named it.
        path: the network that its next peer connections pass, None for a good one.
        frames: how many it has decoded, by stream.
        longest_gap: seconds between two pictures, at most; may be set to 0 to begin anew.
        sizes: the sizes of its pictures, by stream.
        newest_size: of its newest picture, by stream.
        told: what it was told of each stream, without `STREAMING_`.
        byes: why its peer connections ended.
        connections: they, by id.
    """

    def __init__(self, book: Book, connection: ClientConnection) -> None:
        super().__init__(book, connection)
        self.path: ImpairedPath | None = None
        self.frames: dict[str, int] = {}
        self.longest_gap = 0.0
        self.sizes: dict[str, set[tuple[int, int]]] = {}
        self.newest_size: dict[str, tuple[int, int]] = {}
        self.told: dict[str, list[str]] = {}
        self.byes: list[str] = []
        self.connections: dict[str, RTCPeerConnection] = {}
        self.offers: list[dict[str, Any]] = []
        self.devices: dict[str, MediaStreamTrack] = {}
        self.relays: list[RTCIceServer] = []
        self._refs: dict[str, str] = {}
        self._places: dict[tuple[str, str], str] = {}
        self._routes: dict[str, ImpairedPath | None] = {}
        self._receivers: dict[tuple[str, str], RtpReceiver] = {}
        self._news = asyncio.Event()
        self._turn = asyncio.Lock()
        self._leaving = False
        self._tasks: set[asyncio.Task[None]] = set()

    def _hear(self, method: str, params: dict[str, Any]) -> None:
        super()._hear(method, params)
        if method == "rois.stream.notify_stream_status":
            self._refs[params["stream_id"]] = params["component_ref"]
            self._note_status(params["stream_id"], params["status"])
        elif method == "signaling.offer":
            self.offers.append(params)
            self._start(self._answer(params))
        elif method == "signaling.candidate":
            self._start(self._add(params))
        elif method == "signaling.bye":
            self.byes.append(params["reason"])
            if params["peer_id"] in self.connections:
                self._start(self.connections[params["peer_id"]].close())
        self._news.set()

    @property
    def playing(self) -> dict[str, str]:
        """Its streams that have not ended, by component."""
        return {ref: stream_id for stream_id, ref in self._refs.items() if self.told[stream_id][-1] != "NOT_CONNECTED"}

    def _note_status(self, stream_id: str, status: str) -> None:
        told = self.told.setdefault(stream_id, [])
        assert told[-1:] != ["NOT_CONNECTED"], f"{stream_id} has ended, and is {status} (I4)"
        told.append(status.removeprefix("STREAMING_"))

    def _start(self, work: Awaitable[None]) -> None:
        task = asyncio.ensure_future(work)
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    async def _answer(self, offer: dict[str, Any]) -> None:
        async with self._turn:
            if self._leaving:
                return
            peer_id = offer["peer_id"]
            connection = self.connections.get(peer_id) or self._open(peer_id)
            self._places.update({(peer_id, each["mid"]): each["stream_id"] for each in offer["streams"]})
            route = self._routes[peer_id]
            sdp = offer["sdp"] if route is None else route.to_viewer(offer["sdp"])
            await connection.setRemoteDescription(RTCSessionDescription(sdp, "offer"))
            for agent in {each.receiver.transport.transport._connection for each in connection.getTransceivers()}:
                if "connect" not in vars(agent):
                    stop_consent_when_closed(agent)
            self._plug_in(connection, offer["streams"])
            await connection.setLocalDescription(await connection.createAnswer())
            sdp = connection.localDescription.sdp
            sdp = sdp if route is None else route.to_engine(sdp)
            # Another offer, a farewell or an end may have come before it.
            with suppress(asyncio.CancelledError):
                await self.ask("signaling.answer", peer_id=peer_id, generation=offer["generation"], sdp=sdp)

    def _plug_in(self, connection: RTCPeerConnection, streams: list[dict[str, str]]) -> None:
        places = {each.mid: each for each in connection.getTransceivers()}
        for each in streams:
            if each["direction"] != "recvonly":
                places[each["mid"]].sender.replaceTrack(self.devices[each["kind"]])
                places[each["mid"]].direction = each["direction"]

    async def _add(self, params: dict[str, Any]) -> None:
        async with self._turn:
            text, connection = params["candidate"], self.connections.get(params["peer_id"])
            if connection is None or not text:
                return
            candidate = candidate_from_sdp(text.removeprefix("candidate:"))
            candidate.sdpMid = params["sdp_mid"]
            await connection.addIceCandidate(candidate)

    def _open(self, peer_id: str) -> RTCPeerConnection:
        connection = RTCPeerConnection(
            RTCConfiguration(iceServers=self.relays, bundlePolicy=RTCBundlePolicy.MAX_BUNDLE)
        )
        self.connections[peer_id], self._routes[peer_id] = connection, self.path

        remote = RemoteClock()

        def play(track: MediaStreamTrack) -> None:
            (transceiver,) = (each for each in connection.getTransceivers() if each.receiver.track is track)
            receiver = RtpReceiver(transceiver, SystemClock(), remote)
            self._receivers[peer_id, str(transceiver.mid)] = receiver
            self._start(self._count(receiver.source, peer_id, str(transceiver.mid)))

        connection.on("track", play)
        return connection

    async def _count(self, source: MediaSource[RawVideo | RawAudio], peer_id: str, mid: str) -> None:
        last = float("inf")
        async with source.open() as frames:
            async for frame in frames:
                stream_id = self._places[peer_id, mid]
                if isinstance(frame, RawVideo):
                    before, last = last, time.monotonic()
                    self.longest_gap = max(self.longest_gap, last - before)
                    self.newest_size[stream_id] = (frame.width, frame.height)
                    self.sizes.setdefault(stream_id, set()).add((frame.width, frame.height))
                self.frames[stream_id] = self.frames.get(stream_id, 0) + 1
                self._news.set()

    async def until(self, so: Callable[[], object], within: float = MEDIA_PATIENCE) -> None:
        """Wait until a condition on its messages and frames holds.

        Raises:
            TimeoutError: it never was; a note says what there was instead.
        """
        try:
            async with asyncio.timeout(within):
                while not so():
                    self._news.clear()
                    await self._news.wait()
        except TimeoutError as vain:
            vain.add_note(self._account())
            raise

    def _account(self) -> str:
        """Return its messages and frames, for the message of a failed test."""
        lines = [f"statuses {self.told}, frames {self.frames}, byes {self.byes}, {len(self.offers)} offers"]
        if self.gone.is_set():
            lines.append(f"its connection to the gateway has ended: {self.close_code} {self.close_reason}")
        lines += [f"peer connection {peer_id}: {each.connectionState}" for peer_id, each in self.connections.items()]
        lines += [f"{receiver.figures} of section {section}" for section, receiver in self._receivers.items()]
        return "\n".join(lines)

    async def learn_relays(self) -> None:
        """Ask the gateway for servers that help to reach the avatar."""
        self.relays = [RTCIceServer(**each) for each in (await self.ask("signaling.ice_servers"))["ice_servers"]]

    async def connect(self, component_ref: str = VIDEO, codecs: str = "") -> str:
        """Connect a stream and return its id."""
        given = [{"name": "encoding_parameters", "data_type_ref": "String", "value": codecs}] if codecs else []
        answer = await self.ask("rois.stream.connect_stream", component_ref=component_ref, parameters=given)
        assert answer["return_code"] == "OK", answer
        return str(answer["stream_id"])

    async def send(self, component_ref: str) -> str:
        """Connect a stream in which this side sends its device."""
        way = {"name": "transport_parameters", "data_type_ref": "String", "value": '{"direction": "sendonly"}'}
        answer = await self.ask("rois.stream.connect_stream", component_ref=component_ref, parameters=[way])
        assert answer["return_code"] == "OK", answer
        return str(answer["stream_id"])

    async def play(self, component_ref: str = VIDEO, codecs: str = "") -> str:
        """Connect a stream, and wait until it runs and is seen."""
        stream_id = await self.connect(component_ref, codecs)
        await self.is_now(stream_id, "RUNNING")
        await self.sees(stream_id)
        return stream_id

    async def sees(self, stream_id: str, frames: int = 3, within: float = MEDIA_PATIENCE) -> None:
        """Wait for so many more frames of a stream."""
        goal = self.frames.get(stream_id, 0) + frames
        await self.until(lambda: self.frames.get(stream_id, 0) >= goal, within)

    async def is_now(self, stream_id: str, status: str, within: float = MEDIA_PATIENCE) -> None:
        """Wait until the newest status of a stream is this one."""
        await self.until(lambda: self.told.get(stream_id, [])[-1:] == [status], within)

    async def becomes(self, component_ref: str, *statuses: str, within: float = MEDIA_PATIENCE) -> str:
        """Ask until a component's status is one of these; return it."""
        async with asyncio.timeout(within):
            while (status := await self.status(component_ref)) not in statuses:  # noqa: ASYNC110
                await asyncio.sleep(0.05)
        return status

    async def leave(self) -> None:
        """End all media of this side; an answer that has been begun is given before, and no other one."""
        self._leaving = True
        async with self._turn:
            for connection in self.connections.values():
                await connection.close()
        for task in tuple(self._tasks):
            task.cancel()
        await asyncio.gather(*self._tasks, return_exceptions=True)


async def _watch(url: str, codec: str, path: str = "") -> None:
    """Print a line for each picture, and why a peer connection ended, for as long as this process lives.

    Where they have come and stay away for two seconds it asks for another peer connection, as the SDKs do.

    Args:
        url: of the gateway.
        codec: of the pictures.
        path: of a Unix socket by which the gateway is reached, where this process has another network.
    """
    options: dict[str, Any] = {}
    if path:
        options["sock"] = socket.socket(socket.AF_UNIX)
        options["sock"].connect(path)
    async with Book().application(Spectator, url, extended=True, **options) as app:
        await app.learn_relays()
        video = await app.connect(VIDEO, json.dumps({"codecs": [codec]}))
        patience = MEDIA_PATIENCE
        while True:
            try:
                await app.until(lambda: app.frames.get(video) or app.byes, patience)
                if app.frames.pop(video, 0):
                    patience = 2.0
                    print("picture", flush=True)
                for reason in app.byes:
                    print(reason, flush=True)
                app.byes.clear()
            except TimeoutError:
                await app.ask("signaling.restart", peer_id=next(reversed(app.connections)))
                patience = MEDIA_PATIENCE


if __name__ == "__main__":
    asyncio.run(_watch(*sys.argv[1:]))
