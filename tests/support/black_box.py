"""An application written from `docs/reference/wire.md` alone: `websockets`, `aiortc`, and nothing of this project.

Run as a program it is a viewer of its own: it plays the avatar's pictures and prints a line with number and arrival for
each, until it is ended: `python -m tests.support.black_box ws://127.0.0.1:8765/ video/H264`.
"""

import asyncio
import itertools
import json
import sys
from collections.abc import AsyncIterator, Callable, Sequence
from contextlib import asynccontextmanager, suppress
from dataclasses import dataclass, field
from typing import Any, Final, TypeVar

from aiortc import (
    MediaStreamTrack,
    RTCBundlePolicy,
    RTCConfiguration,
    RTCIceServer,
    RTCPeerConnection,
    RTCSessionDescription,
)
from aiortc.mediastreams import MediaStreamError
from av import AudioFrame, VideoFrame
from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import ConnectionClosed

from tests.support.black_box_media import Media, Picture

VIDEO: Final = "avatar/video_streaming"
AUDIO: Final = "avatar/audio_streaming"
STATUS: Final = "rois.stream.notify_stream_status"
H264: Final = ("video/H264",)
VP8: Final = ("video/VP8",)

_PATIENCE: Final = 30.0

T = TypeVar("T")
Message = dict[str, Any]


class Refused(Exception):
    """JSON-RPC error response of the gateway."""

    def __init__(self, error: Message) -> None:
        super().__init__(f"{error['message']} ({error['code']})")
        self.code: int = error["code"]
        self.data = error.get("data")


class News:
    """Wakes waiters of conditions at each event."""

    def __init__(self) -> None:
        self._waiting: set[asyncio.Future[None]] = set()

    def happened(self) -> None:
        for each in self._waiting:
            if not each.done():
                each.set_result(None)

    async def until(self, condition: Callable[[], T], within: float | None = _PATIENCE) -> T:
        """Return what `condition` gives as soon as that is true."""
        async with asyncio.timeout(within):
            while not (outcome := condition()):
                woken: asyncio.Future[None] = asyncio.get_running_loop().create_future()
                self._waiting.add(woken)
                try:
                    await woken
                finally:
                    self._waiting.discard(woken)
            return outcome


@dataclass
class Peer:
    """One peer connection, as offered."""

    connection: RTCPeerConnection
    replaces: str | None
    offers: list[Message] = field(default_factory=list)
    answer_codes: list[str] = field(default_factory=list)
    media: dict[str, Media] = field(default_factory=dict)
    """By mid."""
    bye: str | None = None

    def directions(self) -> dict[str, str | None]:
        """What is negotiated for each section now."""
        return {str(each.mid): each.currentDirection for each in self.connection.getTransceivers()}

    def codecs(self) -> set[str]:
        """The formats that the newest offer lists."""
        lines = self.offers[-1]["sdp"].splitlines()
        return {line.split()[1].split("/")[0] for line in lines if line.startswith("a=rtpmap:")}


class Wire:
    """JSON-RPC with a gateway.

    Attributes:
        news: happens whenever anything arrives.
        transcript: all that arrived here, in order: ("reply", method of the request) and (method, params).
        ended: why the connection ended; None while it is open.
    """

    def __init__(self, connection: ClientConnection) -> None:
        self.news = News()
        self.transcript: list[tuple[str, Any]] = []
        self.ended: ConnectionClosed | None = None
        self._connection = connection
        self._ids = itertools.count(1)
        self._waiting: dict[object, tuple[str, asyncio.Future[Message]]] = {}

    async def ask(self, method: str, **params: Any) -> Message:
        """Ask and return the result."""
        request_id = next(self._ids)
        message = {"jsonrpc": "2.0", "id": request_id, "method": method, "params": params}
        answer = await self.exchange(json.dumps(message), request_id, method)
        if "error" in answer:
            raise Refused(answer["error"])
        result: Message = answer["result"]
        return result

    async def exchange(self, text: str | bytes, answered_as: object = None, name: str = "") -> Message:
        """Send `text` and return the answer whose id is `answered_as`."""
        answer: asyncio.Future[Message] = asyncio.get_running_loop().create_future()
        self._waiting[answered_as] = (name, answer)
        await self._connection.send(text)
        async with asyncio.timeout(_PATIENCE):
            return await answer

    async def drop(self) -> None:
        """End the connection as a power cut would: without a closing handshake."""
        self._connection.transport.abort()
        await self._connection.wait_closed()

    async def read(self) -> None:
        """Take what arrives until the connection ends."""
        try:
            while True:
                self._take(json.loads(await self._connection.recv()))
                self.news.happened()
        except ConnectionClosed as closed:
            self.ended = closed
            for _, waiting in self._waiting.values():
                if not waiting.done():
                    waiting.set_exception(closed)
            self.news.happened()

    def _take(self, message: Message) -> None:
        if "method" not in message:
            name, waiting = self._waiting.pop(message["id"])
            self.transcript.append(("reply", name))
            if not waiting.done():
                waiting.set_result(message)
            return
        self.transcript.append((message["method"], message["params"]))

    def told(self, method: str) -> list[Message]:
        """The params of all notifications of `method` so far."""
        return [params for name, params in self.transcript if name == method]


class Application(Wire):
    """An application with its media; made by `application`.

    Attributes:
        peers: the peer connections by id.
        answers: whether offers are answered.
        candidates_first: whether candidates are sent before the answer they belong to.
    """

    def __init__(self, connection: ClientConnection, tasks: asyncio.TaskGroup) -> None:
        super().__init__(connection)
        self.peers: dict[str, Peer] = {}
        self.answers = True
        self.candidates_first = False
        self.devices: dict[str, MediaStreamTrack] = {}
        """What is sent in the streams of a kind, where this application is to send."""
        self._tasks = tasks
        self._ice_servers: list[RTCIceServer] = []
        self._places: dict[str, tuple[str, str]] = {}
        self._players: list[asyncio.Task[None]] = []

    def statuses(self, stream_id: str) -> list[str]:
        """Return the statuses notified of a stream so far, without `STREAMING_`."""
        notices = (params for params in self.told(STATUS) if params["stream_id"] == stream_id)
        return [params["status"].removeprefix("STREAMING_") for params in notices]

    async def until_status(self, stream_id: str, status: str, within: float = _PATIENCE) -> None:
        """Wait until `status` is the newest notified of a stream."""
        try:
            await self.news.until(lambda: self.statuses(stream_id)[-1:] == [status], within)
        except TimeoutError:
            raise TimeoutError(f"not {status} within {within:g} s: {self._condition(stream_id)}") from None

    def _condition(self, stream_id: str) -> str:
        """Return what is known of a stream, for the message of a wait in vain."""
        peers = [
            (each.connection.connectionState, [media.arrived for media in each.media.values()], each.bye)
            for each in self.peers.values()
        ]
        faults = [each.get("error_type") for each in self.told("rois.system.notify_error")]
        return f"statuses {self.statuses(stream_id)}; state, frames and bye of peers {peers}; faults {faults}"

    async def hello(self) -> str:
        """Say which extensions this application speaks; returns the client id."""
        answer = await self.ask("openrois.hello", version="1", extensions=["rois.stream", "signaling"])
        assert answer["return_code"] == "OK"
        return str(answer["client_id"])

    async def connect_stream(
        self, component_ref: str, codecs: Sequence[str] | None = None, direction: str | None = None
    ) -> str:
        """Connect a stream and return its id; its offer is answered by itself."""
        servers = (await self.ask("signaling.ice_servers"))["ice_servers"]
        self._ice_servers = [RTCIceServer(**server) for server in servers]
        parameters = [] if codecs is None else [encoding_parameters(json.dumps({"codecs": list(codecs)}))]
        if direction is not None:
            value = json.dumps({"direction": direction})
            parameters.append({"name": "transport_parameters", "data_type_ref": "String", "value": value})
        answer = await self.ask("rois.stream.connect_stream", component_ref=component_ref, parameters=parameters)
        assert answer["return_code"] == "OK", answer
        return str(answer["stream_id"])

    async def play(self, component_ref: str, codecs: Sequence[str] | None = None, direction: str | None = None) -> str:
        """Connect a stream and wait until it is notified as running."""
        stream_id = await self.connect_stream(component_ref, codecs, direction)
        await self.until_status(stream_id, "RUNNING")
        return stream_id

    async def act(self, verb: str, stream_id: str) -> str:
        """Suspend, resume or disconnect a stream; returns the return code."""
        return str((await self.ask(f"rois.stream.{verb}_stream", stream_id=stream_id))["return_code"])

    async def status(self, stream_id: str) -> str:
        """Ask for the status of a stream."""
        return str((await self.ask("rois.stream.query_stream_status", stream_id=stream_id))["status"])

    def peer_of(self, stream_id: str) -> Peer:
        """The newest peer connection that offered a stream."""
        return self.peers[self._places[stream_id][0]]

    def media(self, stream_id: str) -> Media:
        """What arrived where a stream was offered last."""
        peer_id, mid = self._places[stream_id]
        return self.peers[peer_id].media[mid]

    async def packets_lost(self, stream_id: str) -> int:
        """How many packets of a stream aiortc has missed, which asks for them again and shows what it has meanwhile."""
        peer_id, mid = self._places[stream_id]
        places = {each.mid: each for each in self.peers[peer_id].connection.getTransceivers()}
        stats = await places[mid].receiver.getStats()
        return sum(each.packetsLost for each in stats.values() if each.type == "inbound-rtp")

    async def pictures(self, stream_id: str, count: int, within: float = _PATIENCE) -> list[Picture]:
        """Wait for the next `count` pictures of a stream and return them."""
        media = self.media(stream_id)
        start = len(media.pictures)
        await self.news.until(lambda: len(media.pictures) >= start + count, within)
        return media.pictures[start : start + count]

    async def frames(self, stream_id: str, count: int, within: float = _PATIENCE) -> int:
        """Wait for the next `count` pictures of a stream, with a stamp or without; returns how many there were."""
        media = self.media(stream_id)
        start = media.arrived
        await self.news.until(lambda: media.arrived >= start + count, within)
        return media.arrived

    async def negotiate(self) -> None:
        """Answer offers, in order, until the connection ends."""
        with suppress(ConnectionClosed):
            for position in itertools.count():
                method, params = await self._entry(position)
                if method == "signaling.offer":
                    await self._take_offer(params)
                elif method == "signaling.bye" and (peer := self.peers.get(params["peer_id"])):
                    peer.bye = params["reason"]
                    # In a task of its own: aiortc's close must not be cancelled half-way.
                    self._tasks.create_task(peer.connection.close())
                self.news.happened()

    async def _entry(self, position: int) -> tuple[str, Any]:
        await self.news.until(lambda: len(self.transcript) > position, within=None)
        return self.transcript[position]

    async def _take_offer(self, offer: Message) -> None:
        peer_id = offer["peer_id"]
        peer = self.peers.get(peer_id)
        if peer is None:
            peer = self.peers[peer_id] = self._open(offer.get("replaces"))
        peer.offers.append(offer)
        self._places.update({each["stream_id"]: (peer_id, each["mid"]) for each in offer["streams"]})
        if not self.answers:
            return
        sdp, candidates = without_candidates(await self.described(offer))
        about = {"peer_id": peer_id, "generation": offer["generation"]}
        if self.candidates_first:
            await self._trickle(about, candidates)
        peer.answer_codes.append((await self.ask("signaling.answer", **about, sdp=sdp))["return_code"])
        if not self.candidates_first:
            await self._trickle(about, candidates)

    async def described(self, offer: Message) -> str:
        """Apply an offer and return the answer, which is not sent yet."""
        connection = self.peers[offer["peer_id"]].connection
        await connection.setRemoteDescription(RTCSessionDescription(offer["sdp"], "offer"))
        places = {each.mid: each for each in connection.getTransceivers()}
        for each in offer["streams"]:
            if each["direction"] != "recvonly" and each["kind"] in self.devices:
                places[each["mid"]].sender.replaceTrack(self.devices[each["kind"]])
                places[each["mid"]].direction = each["direction"]
        await connection.setLocalDescription(await connection.createAnswer())
        sdp: str = connection.localDescription.sdp
        return sdp

    async def _trickle(self, about: Message, candidates: list[tuple[int, str | None]]) -> None:
        for index, candidate in candidates:
            place = {"sdp_mid": None, "sdp_m_line_index": index}
            await self.ask("signaling.candidate", **about, candidate=candidate, **place)

    def _open(self, replaces: str | None) -> Peer:
        configuration = RTCConfiguration(iceServers=self._ice_servers, bundlePolicy=RTCBundlePolicy.MAX_BUNDLE)
        peer = Peer(RTCPeerConnection(configuration), replaces)

        def play(track: MediaStreamTrack) -> None:
            place = next(each for each in peer.connection.getTransceivers() if each.receiver.track is track)
            media = peer.media[str(place.mid)] = Media(track.kind)
            self._players.append(self._tasks.create_task(self._consume(media, track)))

        peer.connection.on("track", play)
        peer.connection.on("connectionstatechange", self.news.happened)
        return peer

    async def _consume(self, media: Media, track: MediaStreamTrack) -> None:
        with suppress(MediaStreamError):
            while True:
                frame = await track.recv()
                if isinstance(frame, VideoFrame):
                    media.take_picture(frame)
                elif isinstance(frame, AudioFrame):
                    media.take_sound(frame)
                self.news.happened()
        media.ended = True
        self.news.happened()

    async def close(self) -> None:
        """End all media."""
        for peer in self.peers.values():
            await peer.connection.close()
        for player in self._players:  # a track that never began is never ended by aiortc
            player.cancel()


def encoding_parameters(text: str) -> Message:
    """The parameter of that name with `text` as its value."""
    return {"name": "encoding_parameters", "data_type_ref": "String", "value": text}


def without_candidates(sdp: str) -> tuple[str, list[tuple[int, str | None]]]:
    """Take the candidates out of a description, to be trickled: each with the index of its section, and the end."""
    kept: list[str] = []
    candidates: list[tuple[int, str | None]] = []
    index = -1
    for line in sdp.splitlines():
        index += line.startswith("m=")
        if line.startswith("a=candidate:"):
            candidates.append((index, line.removeprefix("a=")))
        elif line != "a=end-of-candidates":
            kept.append(line)
    return "\r\n".join(kept) + "\r\n", [*candidates, (0, None)]


@asynccontextmanager
async def application(url: str) -> AsyncIterator[Application]:
    """Connect an application to the gateway at `url`; when the block ends it leaves, and its media ends."""
    dialled = connect(url, compression=None, max_size=4 << 20, close_timeout=2)
    async with dialled as connection, asyncio.TaskGroup() as tasks:
        app = Application(connection, tasks)
        working = [tasks.create_task(app.read()), tasks.create_task(app.negotiate())]
        try:
            yield app
        finally:
            for task in working:
                task.cancel()
            await app.close()


async def _watch(url: str, codec: str) -> None:
    async with application(url) as app:
        stream_id = await app.play(VIDEO, [codec])
        while True:
            for picture in await app.pictures(stream_id, 1):
                print(picture.number, picture.at, flush=True)


if __name__ == "__main__":
    asyncio.run(_watch(*sys.argv[1:3]))
