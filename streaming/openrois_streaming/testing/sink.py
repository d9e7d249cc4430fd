"""Measuring viewer: an application's end of one peer connection.

It answers the offers of a session and reads the stamps and markers of the synthetic sources::

    async with MeasuringSink() as sink:
        await session.apply_answer(await sink.respond(offer))
        await sink.sees(30)
        print(sink.pictures().fps, sink.pictures().delay)
"""

import asyncio
from collections.abc import Callable
from typing import Self, TypeVar

from aiortc import RTCPeerConnection
from openrois_signaling.messages import Answer, Offer

from openrois_streaming.clock import MediaClock, SystemClock, wall_at
from openrois_streaming.peer.receiver import RtpReceiver
from openrois_streaming.receive.decoded import DecodedPicture
from openrois_streaming.source import stamp
from openrois_streaming.source.source import MediaSource, RawAudio, RawVideo
from openrois_streaming.stats import ReceiverFigures
from openrois_streaming.tasks import OwnedTasks
from openrois_streaming.testing.input_sender import InputSender
from openrois_streaming.testing.lipsync import LipSync, LipSyncFigures
from openrois_streaming.testing.path import ImpairedPath
from openrois_streaming.testing.pictures import PictureFigures, PictureLog, SeenPicture
from openrois_streaming.testing.sounds import SoundFigures, SoundLog
from openrois_streaming.viewing.answering import AnsweringConnection, ViewedSection

T = TypeVar("T")

PATIENCE = 10.0
"""Default timeout in seconds."""


class MeasuringSink:
    """Viewer that plays and measures all streams of a session. Sections are known by their mid, "0" is the first one.

    A picture counts when it is decoded; none is held back for smooth display, and one that is overtaken while the loop
    is busy counts as missed. Sound counts when it is played, behind a buffer against jitter and losses. The peer
    connection is opened by the first offer; a session that starts another peer needs another sink.

    Args:
        clock: clock of the source's stamps and markers; this machine's by default.
        path: the bad network between the session and this sink; None for none.
        on_picture: called with each picture, in order; its exceptions end the measuring, and are raised in waiting
            calls.
        on_media: likewise, called with all decoded media, with capture times by the sender's reports.
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
        self._connection: AnsweringConnection | None = None
        self._pictures: dict[str, PictureLog] = {}
        self._sounds: dict[str, SoundLog] = {}
        self._receivers: dict[str, RtpReceiver] = {}
        self._before: dict[str, ReceiverFigures] = {}
        """Figures of receivers before the count began."""
        self._lipsync, self._reported_lipsync = LipSync(), LipSync()
        self._news = asyncio.Event()
        self._failure: BaseException | None = None
        self._tasks = OwnedTasks("measuring sink", self._failed)
        self.states: list[str] = []
        """The states of the peer connection, in order."""
        self.input: InputSender | None = None
        """Sends operator input, if the session has offered channels."""

    async def __aenter__(self) -> Self:
        return self

    async def __aexit__(self, *_: object) -> None:
        """Close the peer connection."""
        if self._connection is not None:
            await self._connection.close()
        await self._tasks.aclose()

    def __str__(self) -> str:
        """Return all figures, a line for each section."""
        lines = [f"state: {', '.join(self.states) or 'no offer was answered'}"]
        lines += [f"{mid}: {self.pictures(mid)}" for mid in self._pictures]
        lines += [f"{mid}: {self.sound(mid)}" for mid in self._sounds]
        lines += [f"{mid}: {self.received(mid)}" for mid in self._receivers]
        return "\n".join([*lines, f"lip sync: {self.lip_sync()}, as told: {self.told_lip_sync()}"])

    async def respond(self, offer: Offer) -> Answer:
        """Answer an offer of a session; returns the answer as a message."""
        return Answer(peer_id=offer.peer_id, generation=offer.generation, sdp=await self.answer(offer.sdp))

    async def answer(self, sdp: str) -> str:
        """Answer the SDP of an offer; returns the answer as SDP, candidates included."""
        connection = self._connection or self._open()
        offer = sdp if self._path is None else self._path.to_viewer(sdp)
        answer = await connection.answer_offer(offer)
        return answer if self._path is None else self._path.to_engine(answer)

    def pictures(self, mid: str | None = None) -> PictureFigures:
        """Return the figures of a section's pictures; without a name of the only one with pictures.

        Raises:
            LookupError: there is no such section, or more than one.
        """
        log = _one(self._pictures, mid)
        name = next(name for name, each in self._pictures.items() if each is log)
        return log.figures(self._clock.now(), self.received(name).key_frames)

    def sound(self, mid: str | None = None) -> SoundFigures:
        """Return the figures of a section's sound; without a name of the only one with sound.

        Raises:
            LookupError: there is no such section, or more than one.
        """
        return _one(self._sounds, mid).figures(self._clock.now())

    def lip_sync(self) -> LipSyncFigures | None:
        """Return the lip sync as decoded and played; None without both."""
        return self._lipsync.figures()

    def told_lip_sync(self) -> LipSyncFigures | None:
        """Return the lip sync of a player that follows the sender's reports (RFC 3550 section 6.4.1)."""
        return self._reported_lipsync.figures()

    def received(self, mid: str) -> ReceiverFigures:
        """Return the figures of a section's packets, losses and requests since the count began.

        Raises:
            LookupError: there is no such section.
        """
        return self._receivers[mid].figures.since(self._before[mid])

    def sizes(self, mid: str | None = None) -> list[tuple[float, int, int]]:
        """Return the times, widths and heights of the first picture and of the last changes since `restart`."""
        return list(_one(self._pictures, mid).sizes)

    def restart(self) -> None:
        """Restart the count, without the measurements until now."""
        logs: list[PictureLog | SoundLog] = [*self._pictures.values(), *self._sounds.values()]
        for log in logs:
            log.restart(self._clock.now())
        self._before = {mid: receiver.figures for mid, receiver in self._receivers.items()}
        self._lipsync.restart()
        self._reported_lipsync.restart()

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
        """Wait for the next picture; others are counted, and not returned.

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

    def _open(self) -> AnsweringConnection:
        self._connection = AnsweringConnection(
            self._clock, on_state=self._become, on_received=self._watch, on_channels=self._open_input
        )
        return self._connection

    def _open_input(self, connection: RTCPeerConnection) -> None:
        self.input = InputSender(connection, self._news.set)

    def _become(self, state: str) -> None:
        self.states.append(state)
        self._news.set()

    def _failed(self, failure: BaseException) -> None:
        self._failure = failure
        self._news.set()

    def _watch(self, section: ViewedSection) -> None:
        mid, receiver = section.mid, section.receiver
        assert receiver is not None, "its media is received"
        self._receivers[mid], self._before[mid] = receiver, receiver.figures
        if section.kind == "video":
            seen = self._pictures[mid] = PictureLog(self._clock.now())
            self._tasks.start(self._see(receiver.source, seen), f"pictures of {mid}")
        else:
            heard = self._sounds[mid] = SoundLog(self._clock.now())
            self._tasks.start(self._hear(receiver.source, heard), f"sound of {mid}")

    async def _see(self, source: MediaSource[DecodedPicture], log: PictureLog) -> None:
        async with source.open() as pictures:
            async for decoded in pictures:
                picture = decoded.raw()
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
                    self._lipsync.add_picture(captured, seen.delay)
                    self._reported_lipsync.add_picture(captured, wall_at(self._clock, picture.captured_at) - captured)
                self._news.set()

    async def _hear(self, source: MediaSource[RawAudio], log: SoundLog) -> None:
        async with source.open() as blocks:
            async for block in blocks:
                captured = wall_at(self._clock, block.captured_at)
                for click in log.add(block.samples[:, 0], captured, self._clock.wall()):
                    self._lipsync.add_sound(click.second, click.delay)
                    self._reported_lipsync.add_sound(click.second, click.told)
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
