"""What stands around a session in tests: renditions fed by hand, a connection without a network, and an application."""

import asyncio
import itertools
from collections.abc import AsyncIterator, Callable, Hashable, Iterator, Sequence
from contextlib import asynccontextmanager, contextmanager
from typing import Any

import pytest
from aiortc import RTCPeerConnection
from openrois_signaling.messages import Answer, Bye, Candidate, Downward, IceServer, Offer, StreamSection
from openrois_streaming.adaptation.rung import Rung
from openrois_streaming.aiortc_internals.sending import DtlsWire
from openrois_streaming.clock import MediaClock
from openrois_streaming.encoded import EncodedFrame
from openrois_streaming.errors import InvalidCandidate, InvalidDescription, PeerClosed, TooManySections
from openrois_streaming.input.reader import Label
from openrois_streaming.network.guard import GuardFigures
from openrois_streaming.network.settings import NetworkSettings
from openrois_streaming.network.turns import Ingress
from openrois_streaming.peer import peer as peer_module
from openrois_streaming.peer.input_channels import InputSink, MakeChannels, OnMessage
from openrois_streaming.peer.sdp import Answered
from openrois_streaming.peer.section import Section
from openrois_streaming.peer.stream import Stream, StreamChange
from openrois_streaming.publish.key_frames import KeyFrameCause
from openrois_streaming.publish.rendition import DirectMailbox
from openrois_streaming.rtp.reports import ReceiverReport
from openrois_streaming.send.pacer import Outlet
from openrois_streaming.session.session import StreamSession
from openrois_streaming.source.fanout import Fanout, Subscription
from openrois_streaming.source.source import MediaSource, RawAudio
from openrois_streaming.stats import ReceiverFigures

from tests.support.sending import NEGOTIATED, Wires
from tests.support.streaming import FedSource, VirtualClock, settle


def frame(sequence: int, *, keyframe: bool = False, at: float | None = None, data: bytes = b"frame") -> EncodedFrame:
    """One encoded picture; 30 of them are a second."""
    captured_at = sequence / 30 if at is None else at
    return EncodedFrame(data, (data,), round(captured_at * 90_000), 90_000, keyframe, sequence, captured_at)


class FedRendition:
    """A rendition whose frames are given by the test. It records the key frames it is asked for."""

    def __init__(self, mime_type: str, rung: Rung | None = None) -> None:
        self.mime_type = mime_type
        self.rung = rung
        self.demanded: float | None = None
        """The bit rate that a viewer said last that it can take."""
        self.needed = 0.0
        """What a viewer must be able to take."""
        self.source: FedSource[EncodedFrame] = FedSource()
        self.asked: list[KeyFrameCause] = []
        self.prepared = 0
        """How often it was made to run ahead of a viewer."""
        self.wants = 0
        """Feeds that play it, or try to."""
        self._fanout = Fanout(self.source, name=mime_type)
        self._sequence = itertools.count()

    @property
    def readers(self) -> int:
        return self._fanout.readers

    @asynccontextmanager
    async def play(
        self, viewer: Hashable, take: Callable[[EncodedFrame], None], bitrate: float | None = None
    ) -> AsyncIterator[Subscription[EncodedFrame]]:
        async with self._fanout.subscribe(mailbox=DirectMailbox(take)) as subscription:
            self.request_key_frame(KeyFrameCause.START)
            yield subscription

    @asynccontextmanager
    async def prepare(self) -> AsyncIterator[None]:
        self.prepared += 1
        async with self._fanout.subscribe(mailbox=DirectMailbox(lambda _frame: None)):
            yield

    @contextmanager
    def wanted(self) -> Iterator[None]:
        self.wants += 1
        try:
            yield
        finally:
            self.wants -= 1

    def demand(self, viewer: Hashable, bitrate: float) -> None:
        self.demanded = bitrate

    def least(self, viewer: Hashable) -> float:
        return self.needed

    def request_key_frame(self, cause: KeyFrameCause) -> None:
        self.asked.append(cause)

    async def show(self, *, keyframe: bool = False) -> None:
        """Give the next frame to the readers."""
        await self.source.feed(frame(next(self._sequence), keyframe=keyframe))


class FedPublisher:
    """A publisher of `FedRendition`s, of all media types."""

    def __init__(self) -> None:
        self.made: dict[str, FedRendition] = {}
        self.failure: Exception | None = None
        self.rung: Rung | None = None
        """Of the renditions that are made from now on."""
        self.fps: float | None = None
        """How many pictures a second were asked for last."""
        self.full: set[str] = set()
        """Media types that no viewer can be sent."""
        self.broken: set[str] = set()
        """Media types whose encoders fail again and again."""

    def can_encode(self, mime_type: str) -> bool:
        return mime_type not in self.broken

    def has_room(self, mime_type: str) -> bool:
        return mime_type not in self.full

    def renditions(self, mime_type: str, fps: float | None = None) -> tuple[FedRendition]:
        self.fps = fps
        if self.failure is not None:
            raise self.failure
        return (self.made.setdefault(mime_type, FedRendition(mime_type, self.rung)),)


class FakeReception:
    """A receiver whose frames are counted by the test."""

    def __init__(self) -> None:
        self.source: FedSource[RawAudio] = FedSource()
        self.frames = 0
        self.last_frame_at: float | None = None
        self.passing = False
        self.figures = ReceiverFigures(0, 0, 0, 0, 0, 0, 0, 0, 0.0, 0.0, 0.0)

    def pass_media(self, wanted: bool) -> None:
        self.passing = wanted

    def arrive(self, now: float) -> None:
        """Receive a whole frame, which is lost if media is not wanted."""
        if self.passing:
            self.frames += 1
            self.last_frame_at = now


class FakeInlet:
    """An inlet that remembers what was plugged into it, and which source is now."""

    def __init__(self) -> None:
        self.sources: dict[str, MediaSource[Any]] = {}
        self.calls: list[tuple[str, str]] = []

    def plug(self, stream_id: str, source: MediaSource[Any]) -> None:
        self.calls.append(("plug", stream_id))
        self.sources[stream_id] = source

    def unplug(self, stream_id: str) -> None:
        self.calls.append(("unplug", stream_id))
        del self.sources[stream_id]


class FakeChannels:
    """Data channels that are opened, filled and closed by the test."""

    def __init__(self, on_message: OnMessage, on_closed: Callable[[], None]) -> None:
        self.come = on_message
        self.are_open = False
        self.told: list[str | bytes] = []
        self.labels: list[Label] = []
        self._on_closed = on_closed

    def send_message(self, message: str | bytes, label: Label = "control") -> bool:
        if self.are_open:
            self.told.append(message)
            self.labels.append(label)
        return self.are_open

    def close(self) -> None:
        self.are_open = False
        self._on_closed()


class WirelessConnection:
    """Stands in for `BundledConnection`: real sections, no network. What the other end does is done by the test."""

    made: "list[WirelessConnection]"

    @classmethod
    def stand_in(cls, monkeypatch: pytest.MonkeyPatch) -> None:
        """Let peers have such connections for the rest of a test; `made` lists them, and is empty now."""
        monkeypatch.setattr(peer_module, "BundledConnection", cls)
        cls.made = []

    def __init__(
        self,
        ice_servers: Sequence[IceServer],
        network: NetworkSettings,
        guarded: GuardFigures,
        ingress: Ingress,
        clock: MediaClock,
        wall_offset: float,
        on_state: Callable[[str], None],
        on_sign: Callable[[], None],
        on_candidate: Callable[[str | None], None],
    ) -> None:
        self.network = network
        self.find = on_candidate
        self.ice_servers = ice_servers
        self._outlet = Outlet.made(clock, wall_offset, asyncio.get_running_loop().call_later)
        self.sections: list[Section] = []
        self._on_state = on_state
        self._connected = False
        self.hear = on_sign
        self.room = 16
        self.closed_there = False
        """Whether the application has closed it, and that was not notified yet."""
        self.sender_failed = False
        self.misuse = ""
        self.answers_questions = False
        self.questions = 0
        self.candidates: list[str] = []
        self.closed = False
        self.obstacle: asyncio.Event | None = None
        """What descriptions and answers wait for, if anything."""
        self.failure: Exception | None = None
        """What making a description raises, if anything."""
        self.answers: dict[str, Answered] = {}
        """What the application does in the sections of these mids, where that is not what was offered."""
        self._described: list[tuple[Section, Answered]] = []
        self.wires: dict[int, Wires] = {}
        """What each section has sent."""
        self._connection = RTCPeerConnection()
        self.channels: FakeChannels | None = None
        self.make_channels: MakeChannels | None = None
        self.made.append(self)

    def section_for(self, stream: Stream) -> Section:
        for section in self.sections:
            if section.suits(stream):
                return section
        if self.closed_there:
            raise PeerClosed("closed there")
        if len(self.sections) >= self.room:
            raise TooManySections("full")
        section = Section(self._connection, stream.kind, stream.codecs, self._outlet, DtlsWire(), stream.direction)
        if stream.direction != "recvonly":
            section.reception = FakeReception()
        section.transceiver._set_mid(str(len(self.sections)))
        self.sections.append(section)
        return section

    def open_channels(self, make: MakeChannels, on_message: OnMessage, on_closed: Callable[[], None]) -> FakeChannels:
        self.make_channels = make
        self.channels = FakeChannels(on_message, on_closed)
        return self.channels

    async def describe(self, generation: int) -> tuple[str, tuple[StreamSection, ...]]:
        listed = [(section, section.stream_path) for section in self.sections if section.stream_path is not None]
        self._described = [(each, "inactive" if each.stream_path is None else each.direction) for each in self.sections]
        for section in self.sections:
            section.describe()
        for _, path in listed:
            if path is not None and path.generation is None:
                path.generation = generation
        await self._pass()
        if self.failure is not None:
            raise self.failure
        return f"offer {generation}", tuple(
            StreamSection(
                mid=section.mid,
                stream_id=path.stream.stream_id,
                component_ref=path.stream.component_ref,
                kind=section.kind,
                direction=section.direction,
            )
            for section, path in listed
            if path is not None
        )

    async def apply(self, sdp: str) -> tuple[str, ...]:
        await self._pass()
        if sdp == "garbage":
            raise InvalidDescription("it is garbage")
        for section, offered in self._described:
            if section.codec is None:
                codecs = ("audio/opus",) if section.stream_path is None else section.stream_path.stream.codecs
                section.codec = "video/VP8" if "video/VP8" in codecs else codecs[0]
            section.negotiated(self.answers.get(section.mid, offered))
        self._start_senders()
        return tuple(sdp.split()[1:])

    async def add_candidate(self, attribute: str, *, only_check: bool = False) -> None:
        if attribute == "garbage":
            raise InvalidCandidate("it is garbage")
        if not only_check:
            self.candidates.append(attribute)

    async def ask_for_a_sign(self) -> None:
        self.questions += 1
        if self.answers_questions:
            self.hear()

    async def close(self) -> None:
        self.closed = True

    async def _pass(self) -> None:
        if self.obstacle is not None:
            await self.obstacle.wait()

    def become(self, state: str) -> None:
        """The media path reaches a state."""
        self._connected = state == "connected"
        self._start_senders()
        self._on_state(state)

    def _start_senders(self) -> None:
        if self._connected:
            for number, section in enumerate(self.sections):
                if number not in self.wires:
                    self.wires[number] = Wires()
                    section.sender.start(NEGOTIATED, self.wires[number])

    def report(self, highest_sequence: int, mid: int = 0) -> None:
        """Receive a report of the viewer about a section."""
        self.hear()
        path = self.sections[mid].stream_path
        self.sections[mid].highest_sequence = highest_sequence
        if path is not None:
            path.reported(ReceiverReport(highest_sequence, 0.0, 0, 90))


class Application:
    """The other end of a session, as far as signaling goes, on a clock that stands still."""

    def __init__(self, sink: InputSink | None = None) -> None:
        self.clock = VirtualClock()
        self.offers: list[Offer] = []
        self.byes: list[Bye] = []
        self.candidates: list[Candidate] = []
        self.changes: list[StreamChange] = []
        self._ids = itertools.count(1)
        self.session = StreamSession(
            mint=lambda: f"engine/p{next(self._ids)}",
            send=self._receive,
            on_change=self.changes.append,
            clock=self.clock,
            sink=sink,
        )

    def _receive(self, message: Downward) -> None:
        match message:
            case Offer():
                self.offers.append(message)
            case Bye():
                self.byes.append(message)
            case Candidate():
                self.candidates.append(message)

    @property
    def told(self) -> list[tuple[str, str]]:
        return [(change.stream_id, change.status.value) for change in self.changes]

    async def offered(self) -> Offer:
        """The newest offer."""
        await settle()
        return self.offers[-1]

    async def answer(self, sdp: str = "answer", *, offer: Offer | None = None) -> None:
        offer = offer or await self.offered()
        await self.session.apply_answer(Answer(peer_id=offer.peer_id, generation=offer.generation, sdp=sdp))
        await settle()

    async def trickle(self, candidate: str | None, generation: int = 1, peer_id: str = "engine/p1") -> None:
        await self.session.add_candidate(
            Candidate(peer_id=peer_id, generation=generation, candidate=candidate, sdp_mid="0")
        )
