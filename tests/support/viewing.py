"""What stands around a session in tests: renditions fed by hand, a connection without a network, and an application."""

import asyncio
import itertools
from collections.abc import AsyncIterator, Callable, Sequence
from contextlib import asynccontextmanager

from aiortc import RTCPeerConnection
from openrois_signaling.messages import Answer, Bye, Candidate, IceServer, Offer, StreamSection
from openrois_streaming.aiortc_seams import ReceiverReport
from openrois_streaming.encoded import EncodedFrame
from openrois_streaming.errors import InvalidCandidate, InvalidDescription, TooManySections
from openrois_streaming.fanout import DropOldest, Fanout, Subscription
from openrois_streaming.keyframes import KeyFrameCause
from openrois_streaming.sdp import CandidatePolicy
from openrois_streaming.section import Section
from openrois_streaming.session import StreamSession
from openrois_streaming.stream import Stream, StreamChange

from tests.support.streaming import FedSource, VirtualClock, settle


def frame(sequence: int, *, keyframe: bool = False, at: float | None = None, data: bytes = b"frame") -> EncodedFrame:
    """One encoded picture; 30 of them are a second."""
    captured_at = sequence / 30 if at is None else at
    return EncodedFrame(data, round(captured_at * 90_000), 90_000, keyframe, sequence, captured_at)


class FedRendition:
    """A rendition whose frames are given by the test. It records the key frames it is asked for."""

    def __init__(self, mime_type: str) -> None:
        self.mime_type = mime_type
        self.source: FedSource[EncodedFrame] = FedSource()
        self.asked: list[KeyFrameCause] = []
        self._fanout = Fanout(self.source, name=mime_type)
        self._sequence = itertools.count()

    @property
    def readers(self) -> int:
        return self._fanout.readers

    @asynccontextmanager
    async def subscribe(self) -> AsyncIterator[Subscription[EncodedFrame]]:
        async with self._fanout.subscribe(mailbox=DropOldest(8)) as subscription:
            self.request_key_frame(KeyFrameCause.START)
            yield subscription

    def request_key_frame(self, cause: KeyFrameCause) -> None:
        self.asked.append(cause)

    async def play(self, *, keyframe: bool = False) -> None:
        """Give the next frame to whoever reads."""
        await self.source.feed(frame(next(self._sequence), keyframe=keyframe))


class FedPublisher:
    """A publisher of `FedRendition`s, of all media types."""

    def __init__(self) -> None:
        self.renditions: dict[str, FedRendition] = {}
        self.failure: Exception | None = None

    def rendition(self, mime_type: str) -> FedRendition:
        if self.failure is not None:
            raise self.failure
        return self.renditions.setdefault(mime_type, FedRendition(mime_type))


class WirelessConnection:
    """Stands in for `BundledConnection`: real sections, no network. What the other end does is done by the test."""

    made: "list[WirelessConnection]"

    def __init__(
        self,
        ice_servers: Sequence[IceServer],
        policy: CandidatePolicy,
        wall_offset: float,
        on_state: Callable[[str], None],
        on_rtcp: Callable[[], None],
    ) -> None:
        self.ice_servers = ice_servers
        self._wall_offset = wall_offset
        self.sections: list[Section] = []
        self.become = on_state
        self.hear = on_rtcp
        self.room = 16
        self.sender_failed = False
        self.answers_questions = False
        self.questions = 0
        self.candidates: list[str] = []
        self.closed = False
        self.obstacle: asyncio.Event | None = None
        """What descriptions and answers wait for, if anything."""
        self.failure: Exception | None = None
        """What making a description raises, if anything."""
        self._connection = RTCPeerConnection()
        self.made.append(self)

    def section_for(self, stream: Stream) -> Section:
        for section in self.sections:
            if section.suits(stream):
                return section
        if len(self.sections) >= self.room:
            raise TooManySections("full")
        section = Section(self._connection, stream.kind, stream.codecs, self._wall_offset)
        section.transceiver._set_mid(str(len(self.sections)))
        self.sections.append(section)
        return section

    async def describe(self, generation: int) -> tuple[str, tuple[StreamSection, ...]]:
        listed = [(section, section.leg) for section in self.sections if section.leg is not None]
        for _, leg in listed:
            if leg is not None and leg.generation is None:
                leg.generation = generation
        await self._pass()
        if self.failure is not None:
            raise self.failure
        return f"offer {generation}", tuple(
            StreamSection(
                mid=section.mid,
                stream_id=leg.stream.stream_id,
                component_ref=leg.stream.component_ref,
                kind=section.kind,
                direction="recvonly",
            )
            for section, leg in listed
            if leg is not None
        )

    async def apply(self, sdp: str) -> tuple[str, ...]:
        await self._pass()
        if sdp == "garbage":
            raise InvalidDescription("it is garbage")
        for section in self.sections:
            section.codec = section.codec or ("video/VP8" if section.kind == "video" else "audio/opus")
        return tuple(sdp.split()[1:])

    async def add_candidate(self, attribute: str, *, only_check: bool = False) -> None:
        if attribute == "garbage":
            raise InvalidCandidate("it is garbage")
        if not only_check:
            self.candidates.append(attribute)

    async def ask_for_a_sign(self) -> bool:
        self.questions += 1
        return self.answers_questions

    async def close(self) -> None:
        self.closed = True

    async def _pass(self) -> None:
        if self.obstacle is not None:
            await self.obstacle.wait()

    async def take(self, mid: int = 0) -> None:
        """Do what aiortc's sender does: take one frame of a section."""
        async with asyncio.timeout(1):
            await self.sections[mid].track.recv()

    def report(self, highest_sequence: int, mid: int = 0) -> None:
        """Receive a report of the viewer about a section."""
        self.hear()
        leg = self.sections[mid].leg
        self.sections[mid].highest_sequence = highest_sequence
        if leg is not None:
            leg.reported(ReceiverReport(highest_sequence, 0.0, 0, 90))


class Application:
    """The other end of a session, as far as signaling goes, on a clock that stands still."""

    def __init__(self) -> None:
        self.clock = VirtualClock()
        self.offers: list[Offer] = []
        self.byes: list[Bye] = []
        self.changes: list[StreamChange] = []
        self._ids = itertools.count(1)
        self.session = StreamSession(
            mint=lambda: f"engine/p{next(self._ids)}",
            send=self._receive,
            on_change=self.changes.append,
            clock=self.clock,
        )

    def _receive(self, message: Offer | Bye) -> None:
        if isinstance(message, Offer):
            self.offers.append(message)
        else:
            self.byes.append(message)

    @property
    def told(self) -> list[tuple[str, str]]:
        return [(change.stream_id, change.status.value) for change in self.changes]

    async def offered(self) -> Offer:
        """The newest offer."""
        await settle()
        return self.offers[-1]

    async def answer(self, sdp: str = "answer", *, offer: Offer | None = None) -> None:
        offer = offer or await self.offered()
        await self.session.answer(Answer(peer_id=offer.peer_id, generation=offer.generation, sdp=sdp))
        await settle()

    async def trickle(self, candidate: str | None, generation: int = 1, peer_id: str = "engine/p1") -> None:
        await self.session.candidate(
            Candidate(peer_id=peer_id, generation=generation, candidate=candidate, sdp_mid="0")
        )
