"""Real media on this machine: an engine with a synthetic avatar, and viewers built on aiortc and on Chromium."""

import asyncio
import itertools
from collections.abc import AsyncIterator, Callable, Coroutine, Iterator, Sequence
from contextlib import asynccontextmanager, contextmanager, suppress

import aioice.ice
import pytest
from aiortc import MediaStreamTrack, RTCConfiguration, RTCPeerConnection, RTCSessionDescription
from aiortc.mediastreams import MediaStreamError
from aiortc.rtcconfiguration import RTCBundlePolicy
from aiortc.sdp import candidate_from_sdp
from openrois_signaling.messages import Answer, Bye, Candidate, Downward, IceServer, Offer
from openrois_streaming.clock import SystemClock, wall_at
from openrois_streaming.errors import SessionError
from openrois_streaming.network.settings import NetworkSettings
from openrois_streaming.peer.stream import StreamChange
from openrois_streaming.publish.publisher import AudioPublisher, VideoPublisher
from openrois_streaming.session.session import StreamSession
from openrois_streaming.source.source import MediaSource, RawVideo
from openrois_streaming.state import StreamStatus
from openrois_streaming.synthetic import ColourBars, Tone

PATIENCE = 25.0
"""Seconds that anything here may take; on an idle machine all of it takes less than one."""


class News:
    """Wakes waiters of conditions: engine and viewers report each event here."""

    def __init__(self) -> None:
        self._event = asyncio.Event()

    def tell(self) -> None:
        self._event.set()

    async def until(self, so: Callable[[], object], patience: float = PATIENCE) -> None:
        async with asyncio.timeout(patience):
            while not so():
                self._event.clear()
                await self._event.wait()


class Interruptible:
    """A source of pictures that a test can let fail, hold, or hand over late."""

    def __init__(self, source: MediaSource[RawVideo]) -> None:
        self.failure: Exception | None = None
        """What it fails with, each time that it is opened, until a test takes it away."""
        self.delay = 0.0
        """Seconds from the capture of a picture to its being there; the ones in between are lost."""
        self.captured: list[float] = []
        """When each picture was captured that it handed over, as the time of day."""
        self.running = asyncio.Event()
        self.running.set()
        self._source = source

    @asynccontextmanager
    async def open(self) -> AsyncIterator[AsyncIterator[RawVideo]]:
        async with self._source.open() as frames:
            yield self._pass(frames)

    async def _pass(self, frames: AsyncIterator[RawVideo]) -> AsyncIterator[RawVideo]:
        async for frame in frames:
            await self.running.wait()
            await asyncio.sleep(self.delay)
            if self.failure is not None:
                raise self.failure
            self.captured.append(wall_at(SystemClock(), frame.captured_at))
            yield frame


class HastyClock(SystemClock):
    """Runs `speed` times as fast as time does, so that limits of seconds are reached in tenths."""

    def __init__(self, speed: float) -> None:
        self._speed = speed

    def now(self) -> float:
        return super().now() * self._speed

    async def sleep_until(self, deadline: float) -> None:
        await SystemClock().sleep_until(deadline / self._speed)


class Engine:
    """The engine's end: a session with one application, a small video and a tone."""

    def __init__(
        self, news: News, speed: float, network: NetworkSettings, ice_servers: Sequence[IceServer] = ()
    ) -> None:
        self.news = news
        clock = SystemClock()
        self.source = Interruptible(ColourBars(320, 180, clock=clock))
        self.video = VideoPublisher(self.source, clock=clock, stamp=True, name="bars")
        self.audio = AudioPublisher(Tone(clock=clock), clock=clock, name="tone")
        self.offers: list[Offer] = []
        self.byes: list[Bye] = []
        self.changes: list[StreamChange] = []
        self.candidates: list[Candidate] = []
        self.application: Callable[[Offer], Coroutine[None, None, None]] | None = None
        """Answers offers."""
        self.trickled: Callable[[Candidate], Coroutine[None, None, None]] | None = None
        """Takes candidates."""
        self.failures: list[BaseException] = []
        self._answering: set[asyncio.Task[None]] = set()
        ids = itertools.count(1)
        self.session = StreamSession(
            mint=lambda: f"engine/p{next(ids)}",
            send=self._send,
            on_change=self._changed,
            clock=HastyClock(speed),
            ice_servers=ice_servers,
            network=network,
        )

    def _send(self, message: Downward) -> None:
        if isinstance(message, Bye):
            self.byes.append(message)
        elif isinstance(message, Candidate):
            self.candidates.append(message)
            if self.trickled is not None:
                self._start(self.trickled(message))
        elif isinstance(message, Offer):
            self.offers.append(message)
            if self.application is not None:
                self._start(self.application(message))
        self.news.tell()

    def _start(self, answer: Coroutine[None, None, None]) -> None:
        task = asyncio.ensure_future(self._contained(answer))
        self._answering.add(task)
        task.add_done_callback(self._answering.discard)

    async def _contained(self, answer: Coroutine[None, None, None]) -> None:
        try:
            await answer
        except Exception as error:
            self.failures.append(error)
        self.news.tell()

    def _changed(self, change: StreamChange) -> None:
        self.changes.append(change)
        self.news.tell()

    def connect(self, stream_id: str, kind: str, codecs: Sequence[str] | None = None) -> None:
        if kind == "video":
            self.session.connect(stream_id, "engine/Video", self.video, "video", codecs)
        else:
            self.session.connect(stream_id, "engine/Audio", self.audio, "audio", codecs)

    async def answer(self, offer: Offer, sdp: str) -> None:
        await self.session.apply_answer(Answer(peer_id=offer.peer_id, generation=offer.generation, sdp=sdp))

    async def candidate(self, offer: Offer, candidate: str, mid: str) -> None:
        await self.session.add_candidate(
            Candidate(peer_id=offer.peer_id, generation=offer.generation, candidate=candidate, sdp_mid=mid)
        )

    def statuses(self, stream_id: str) -> list[StreamStatus]:
        return [change.status for change in self.changes if change.stream_id == stream_id]

    async def until(self, stream_id: str, status: StreamStatus, patience: float = PATIENCE) -> None:
        """Wait until the newest status of a stream is `status`."""
        await self.news.until(lambda: self.statuses(stream_id)[-1:] == [status], patience)

    async def close(self) -> None:
        await self.session.close("the test is over")
        for task in tuple(self._answering):
            task.cancel()
            with suppress(asyncio.CancelledError):
                await task


@contextmanager
def some_address() -> Iterator[None]:
    """Media needs an address; where loopback is the only interface, its address is used, which aioice leaves out."""
    with pytest.MonkeyPatch.context() as patch:
        if not aioice.ice.get_host_addresses(use_ipv4=True, use_ipv6=True):
            patch.setattr(aioice.ice, "get_host_addresses", lambda use_ipv4, use_ipv6: ["127.0.0.1"])
        yield


@asynccontextmanager
async def engine(
    *, speed: float = 1.0, network: NetworkSettings | None = None, ice_servers: Sequence[IceServer] = ()
) -> AsyncIterator[Engine]:
    """An engine that leaves nothing running; its session's clock may run faster than time."""
    with some_address():
        one = Engine(News(), speed, network or NetworkSettings(), ice_servers)
        try:
            yield one
        finally:
            await one.close()
        assert one.video.running_encoders == one.audio.running_encoders == 0


class Viewer:
    """An application on aiortc. `bend` may change an answer before it is sent, and an offer before it is read."""

    def __init__(self, engine: Engine) -> None:
        self.engine = engine
        self.connections: dict[str, RTCPeerConnection] = {}
        self.frames: dict[str, int] = {}
        """Frames decoded, by mid."""
        self.states: list[str] = []
        self.bend_offer: Callable[[str], str] = str
        self.bend_answer: Callable[[str], str] = str
        self.refusals: list[SessionError] = []
        self.answered: set[str] = set()
        self._taking = asyncio.Lock()
        self._tasks: list[asyncio.Task[None]] = []
        engine.application = self.respond

    async def respond(self, offer: Offer) -> None:
        connection = self.connections.get(offer.peer_id) or self._open(offer.peer_id)
        await connection.setRemoteDescription(RTCSessionDescription(self.bend_offer(offer.sdp), "offer"))
        await connection.setLocalDescription(await connection.createAnswer())
        try:
            await self.engine.answer(offer, self.bend_answer(connection.localDescription.sdp))
        except SessionError as refusal:
            self.refusals.append(refusal)
        self.answered.add(offer.peer_id)
        self.engine.news.tell()

    async def take(self, candidate: Candidate) -> None:
        """Add a candidate of the engine, in its turn, once the offer that it belongs to is answered."""
        async with self._taking:
            await self.engine.news.until(lambda: candidate.peer_id in self.answered)
            await self._add(candidate)

    async def _add(self, candidate: Candidate) -> None:
        added = candidate_from_sdp(candidate.candidate.removeprefix("candidate:")) if candidate.candidate else None
        if added is not None:
            added.sdpMid = candidate.sdp_mid
        await self.connections[candidate.peer_id].addIceCandidate(added)

    def _open(self, peer_id: str) -> RTCPeerConnection:
        connection = RTCPeerConnection(RTCConfiguration(iceServers=[], bundlePolicy=RTCBundlePolicy.MAX_BUNDLE))
        self.connections[peer_id] = connection
        connection.on("track", lambda track: self._watch(connection, track))
        connection.on("connectionstatechange", lambda: self._state(connection.connectionState))
        return connection

    def _state(self, state: str) -> None:
        self.states.append(state)
        self.engine.news.tell()

    def _watch(self, connection: RTCPeerConnection, track: MediaStreamTrack) -> None:
        mid = next(each.mid for each in connection.getTransceivers() if each.receiver.track is track)
        self._tasks.append(asyncio.create_task(self._count(track, str(mid))))

    async def _count(self, track: MediaStreamTrack, mid: str) -> None:
        with suppress(MediaStreamError):
            while True:
                await track.recv()
                self.frames[mid] = self.frames.get(mid, 0) + 1
                self.engine.news.tell()

    async def plays(self, mid: str = "0", frames: int = 3) -> None:
        """Wait for so many more frames of a section."""
        goal = self.frames.get(mid, 0) + frames
        await self.engine.news.until(lambda: self.frames.get(mid, 0) >= goal)

    async def close(self) -> None:
        self.engine.application = None
        for connection in self.connections.values():
            await connection.close()
        for task in self._tasks:
            task.cancel()
        await asyncio.gather(*self._tasks, return_exceptions=True)


@asynccontextmanager
async def viewer(engine: Engine) -> AsyncIterator[Viewer]:
    """A viewer of `engine` that leaves nothing running."""
    one = Viewer(engine)
    try:
        yield one
    finally:
        await one.close()


def without(sdp: str, *prefixes: str) -> str:
    """`sdp` without the lines that begin so."""
    return "".join(line for line in sdp.splitlines(keepends=True) if not line.startswith(prefixes))


def only_first_section(sdp: str, prefix: str) -> str:
    """`sdp` with the lines that begin so in its first m-section only, where Chromium puts candidates."""
    head, first, *others = sdp.split("m=")
    return "m=".join([head, first, *(without(other, prefix) for other in others)])


def sections(sdp: str) -> list[str]:
    """The m-sections."""
    return ["m=" + section for section in sdp.split("m=")[1:]]
