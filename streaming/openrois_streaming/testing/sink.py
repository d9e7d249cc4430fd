"""A viewer that measures: an application's end of one peer connection.

It answers the offers of a session and reads what the synthetic sources have put into pictures and sound::

    async with MeasuringSink() as sink:
        await session.answer(await sink.respond(offer))
        await sink.sees(30)
        print(sink.pictures().fps, sink.pictures().delay)
"""

import asyncio
from collections.abc import Callable
from typing import Self, TypeVar

from aiortc import MediaStreamTrack, RTCConfiguration, RTCPeerConnection, RTCSessionDescription
from aiortc.rtcconfiguration import RTCBundlePolicy
from openrois_signaling.messages import Answer, Offer

from openrois_streaming.clock import MediaClock, SystemClock, wall_at
from openrois_streaming.peer.receiver import RtpReceiver
from openrois_streaming.receive.figures import ReceiverFigures
from openrois_streaming.receive.remote_time import RemoteClock
from openrois_streaming.source import stamp
from openrois_streaming.source.source import MediaSource, RawAudio, RawVideo
from openrois_streaming.tasks import OwnedTasks
from openrois_streaming.testing.hands import Hands
from openrois_streaming.testing.lipsync import LipSync, LipSyncFigures
from openrois_streaming.testing.path import ImpairedPath
from openrois_streaming.testing.pictures import PictureFigures, PictureLog, SeenPicture
from openrois_streaming.testing.sounds import SoundFigures, SoundLog

T = TypeVar("T")

PATIENCE = 10.0
"""Seconds that is waited by default for what should come at once."""


class MeasuringSink:
    """Plays all that a session sends it, and measures. Sections are known by their mid, "0" is the first one.

    A picture is there when it is decoded; nothing is kept back to show it smoothly, and one that is overtaken while the
    loop is busy counts as missed. Sound is there when it is played, behind a buffer against jitter and losses. The peer
    connection is opened by the first offer; a session that begins anew with another peer needs another sink.

    Args:
        clock: whose wall time the source's stamps and markers are of, as this machine's are.
        path: the bad network between the session and this sink; None for none.
        on_picture: is told each picture, in order; what it raises ends the measuring, and is raised by whoever waits.
        on_media: likewise, is given all that is decoded, with its time of capture by the sender's reports.
    """

    def __init__(
        self,
        *,
        clock: MediaClock | None = None,
        path: ImpairedPath | None = None,
        on_picture: Callable[[SeenPicture], None] | None = None,
        on_media: Callable[[RawVideo | RawAudio], None] | None = None,
    ) -> None:
        self._clock = clock or SystemClock()
        self._path = path
        self._on_picture = on_picture
        self._on_media = on_media
        self._connection: RTCPeerConnection | None = None
        self._pictures: dict[str, PictureLog] = {}
        self._sounds: dict[str, SoundLog] = {}
        self._receivers: dict[str, RtpReceiver] = {}
        self._before: dict[str, ReceiverFigures] = {}
        """What was received before the count began."""
        self._remote = RemoteClock()
        self._lipsync, self._told = LipSync(), LipSync()
        self._news = asyncio.Event()
        self._failure: BaseException | None = None
        self._tasks = OwnedTasks("measuring sink", self._failed)
        self.states: list[str] = []
        """The states of the peer connection, in order."""
        self.hands: Hands | None = None
        """Does what a person does, if the session wants to know it."""

    async def __aenter__(self) -> Self:
        return self

    async def __aexit__(self, *_: object) -> None:
        """Close the peer connection."""
        if self._connection is not None:
            await self._connection.close()
        await self._tasks.aclose()

    def __str__(self) -> str:
        """All figures, a line for each section."""
        lines = [f"state: {', '.join(self.states) or 'no offer was answered'}"]
        lines += [f"{mid}: {self.pictures(mid)}" for mid in self._pictures]
        lines += [f"{mid}: {self.sound(mid)}" for mid in self._sounds]
        lines += [f"{mid}: {self.received(mid)}" for mid in self._receivers]
        return "\n".join([*lines, f"lip sync: {self.lip_sync()}, as told: {self.told_lip_sync()}"])

    async def respond(self, offer: Offer) -> Answer:
        """The answer to an offer of a session, as a message."""
        return Answer(peer_id=offer.peer_id, generation=offer.generation, sdp=await self.answer(offer.sdp))

    async def answer(self, sdp: str) -> str:
        """The answer to the SDP of an offer, as SDP, candidates included."""
        connection = self._connection or self._open()
        offer = sdp if self._path is None else self._path.to_viewer(sdp)
        await connection.setRemoteDescription(RTCSessionDescription(offer, "offer"))
        if connection.sctp is not None and self.hands is None:
            self.hands = Hands(connection, self._news.set)
        await connection.setLocalDescription(await connection.createAnswer())
        answer: str = connection.localDescription.sdp
        return answer if self._path is None else self._path.to_engine(answer)

    def pictures(self, mid: str | None = None) -> PictureFigures:
        """What was seen of a section; without a name of the only one with pictures.

        Raises:
            LookupError: there is no such section, or more than one.
        """
        log = _one(self._pictures, mid)
        name = next(name for name, each in self._pictures.items() if each is log)
        return log.figures(self._clock.now(), self.received(name).key_frames)

    def sound(self, mid: str | None = None) -> SoundFigures:
        """What was heard of a section; without a name of the only one with sound.

        Raises:
            LookupError: there is no such section, or more than one.
        """
        return _one(self._sounds, mid).figures(self._clock.now())

    def lip_sync(self) -> LipSyncFigures | None:
        """How far sound and pictures were apart when they were there; None if there were not both."""
        return self._lipsync.figures()

    def told_lip_sync(self) -> LipSyncFigures | None:
        """How far apart a player has them that goes by the sender's reports (RFC 3550 section 6.4.1)."""
        return self._told.figures()

    def received(self, mid: str) -> ReceiverFigures:
        """The packets of a section, what was lost of them and what was asked for, since the count began.

        Raises:
            LookupError: there is no such section.
        """
        return self._receivers[mid].figures.since(self._before[mid])

    def sizes(self, mid: str | None = None) -> list[tuple[float, int, int]]:
        """When pictures had which width and height: those of the first one, and the last changes since `restart`."""
        return list(_one(self._pictures, mid).sizes)

    def restart(self) -> None:
        """Begin to count anew: what was measured until now is forgotten."""
        logs: list[PictureLog | SoundLog] = [*self._pictures.values(), *self._sounds.values()]
        for log in logs:
            log.restart(self._clock.now())
        self._before = {mid: receiver.figures for mid, receiver in self._receivers.items()}
        self._lipsync.restart()
        self._told.restart()

    async def sees(self, pictures: int = 1, *, mid: str | None = None, within: float = PATIENCE) -> None:
        """Wait for so many more pictures.

        Raises:
            TimeoutError: they do not come within so many seconds.
        """
        await self._more(self._pictures, mid, lambda log: log.count, pictures, within)

    async def hears(self, blocks: int = 1, *, mid: str | None = None, within: float = PATIENCE) -> None:
        """Wait for so many more blocks of sound.

        Raises:
            TimeoutError: they do not come within so many seconds.
        """
        await self._more(self._sounds, mid, lambda log: log.blocks, blocks, within)

    async def picture(self, mid: str | None = None, *, within: float = PATIENCE) -> SeenPicture:
        """Wait for the next picture; one that comes while nobody waits is counted, and not returned.

        Raises:
            TimeoutError: none comes within so many seconds.
        """
        await self.sees(mid=mid, within=within)
        last = _one(self._pictures, mid).last
        assert last is not None, "one was seen"
        return last

    async def until(self, so: Callable[[], object], *, within: float = PATIENCE) -> None:
        """Wait until `so()` is true; it is asked after every picture, every block of sound, and every state.

        Raises:
            TimeoutError: it is not within so many seconds.
        """
        async with asyncio.timeout(within):
            while True:
                if self._failure is not None:
                    raise self._failure
                if so():
                    return
                self._news.clear()
                await self._news.wait()

    async def _more(
        self, logs: dict[str, T], mid: str | None, counted: Callable[[T], int], more: int, within: float
    ) -> None:
        def count() -> int:
            return sum(counted(log) for name, log in logs.items() if mid in (None, name))

        goal = count() + more
        await self.until(lambda: count() >= goal, within=within)

    def _open(self) -> RTCPeerConnection:
        connection = RTCPeerConnection(RTCConfiguration(iceServers=[], bundlePolicy=RTCBundlePolicy.MAX_BUNDLE))
        connection.on("track", self._watch)
        connection.on("connectionstatechange", lambda: self._become(connection.connectionState))
        self._connection = connection
        return connection

    def _become(self, state: str) -> None:
        self.states.append(state)
        self._news.set()

    def _failed(self, failure: BaseException) -> None:
        self._failure = failure
        self._news.set()

    def _watch(self, track: MediaStreamTrack) -> None:
        assert self._connection is not None
        transceivers = self._connection.getTransceivers()
        (transceiver,) = (each for each in transceivers if each.receiver.track is track)
        mid = str(transceiver.mid)
        receiver = self._receivers[mid] = RtpReceiver(transceiver, self._clock, self._remote)
        self._before[mid] = receiver.figures
        if track.kind == "video":
            seen = self._pictures[mid] = PictureLog(self._clock.now())
            self._tasks.start(self._see(receiver.source, seen), f"pictures of {mid}")
        else:
            heard = self._sounds[mid] = SoundLog(self._clock.now())
            self._tasks.start(self._hear(receiver.source, heard), f"sound of {mid}")

    async def _see(self, source: MediaSource[RawVideo], log: PictureLog) -> None:
        async with source.open() as pictures:
            async for picture in pictures:
                at, wall = self._clock.now(), self._clock.wall()
                read = stamp.read(picture.data[: picture.height])
                seen = SeenPicture(at=at, wall=wall, width=picture.width, height=picture.height, stamp=read)
                log.add(seen)
                if self._on_picture is not None:
                    self._on_picture(seen)
                if self._on_media is not None:
                    self._on_media(picture)
                if seen.delay is not None:
                    captured = wall - seen.delay
                    self._lipsync.saw(captured, seen.delay)
                    self._told.saw(captured, wall_at(self._clock, picture.captured_at) - captured)
                self._news.set()

    async def _hear(self, source: MediaSource[RawAudio], log: SoundLog) -> None:
        async with source.open() as blocks:
            async for block in blocks:
                captured = wall_at(self._clock, block.captured_at)
                for click in log.add(block.samples[:, 0], captured, self._clock.wall()):
                    self._lipsync.heard(click.second, click.delay)
                    self._told.heard(click.second, click.told)
                if self._on_media is not None:
                    self._on_media(block)
                self._news.set()


def _one(logs: dict[str, T], mid: str | None) -> T:
    if mid is not None:
        return logs[mid]
    if len(logs) != 1:
        raise LookupError(f"there are {len(logs)} such sections, not one")
    (log,) = logs.values()
    return log
