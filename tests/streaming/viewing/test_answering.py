"""An answering peer connection, with real media between it and a session."""

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import pytest
from openrois_signaling.messages import IceServer, Offer
from openrois_streaming.clock import SystemClock
from openrois_streaming.errors import InvalidCandidate, InvalidDescription
from openrois_streaming.receive.decoded import DecodedPicture
from openrois_streaming.source.shared_inlet import SharedInlet
from openrois_streaming.source.source import RawVideo
from openrois_streaming.state import StreamStatus
from openrois_streaming.synthetic import ColourBars
from openrois_streaming.viewing.answering import AnsweringConnection, ViewedSection

from tests.support.loopback import PATIENCE, Engine, engine

pytestmark = pytest.mark.media


class Far:
    """An application that answers the offers of an engine."""

    def __init__(self, one: Engine) -> None:
        self.engine = one
        self.received: list[ViewedSection] = []
        self.states: list[str] = []
        self.candidates: list[str | None] = []
        self.connection = AnsweringConnection(
            SystemClock(),
            on_state=self._become,
            on_received=self.received.append,
            on_candidate=self.candidates.append,
        )
        one.application = self.respond

    def _become(self, state: str) -> None:
        self.states.append(state)
        self.engine.news.tell()

    async def respond(self, offer: Offer) -> None:
        directions = {each.mid: each.direction for each in offer.streams}
        await self.engine.answer(offer, await self.connection.answer_offer(offer.sdp, directions))


@asynccontextmanager
async def far() -> AsyncIterator[Far]:
    async with engine() as one:
        viewer = Far(one)
        try:
            yield viewer
        finally:
            await viewer.connection.close()
        assert one.failures == []


async def test_pictures_come_with_their_times_and_are_decoded_on_demand() -> None:
    async with far() as viewer:
        viewer.engine.connect("s", "video")
        await viewer.engine.until("s", StreamStatus.RUNNING)
        (section,) = viewer.received
        assert (section.mid, section.kind, section.outgoing) == ("0", "video", None)
        assert viewer.connection.sections == {"0": section}
        assert section.receiver is not None
        assert section.receiver.figures.frames_decoded == 0
        async with asyncio.timeout(PATIENCE), section.receiver.source.open() as pictures:
            async for picture in pictures:
                assert isinstance(picture, DecodedPicture)
                if picture.reported_at is not None:
                    break
        clock = SystemClock()
        assert abs(clock.wall() - picture.reported_at) < 2
        assert picture.captured_at <= clock.now()
        assert section.receiver.figures.frames_decoded > 0
    assert viewer.connection.state == "closed"
    assert viewer.states[-2:] == ["connected", "closed"]


async def test_what_is_put_into_a_section_arrives_and_no_more_after_its_stream() -> None:
    inlet = SharedInlet[RawVideo]("uplink")
    clock = SystemClock()
    async with far() as viewer, inlet.subscribe(1) as arriving:
        session = viewer.engine.session
        session.connect("up", "engine/Video", None, "video", direction="sendonly", inlet=inlet)
        await viewer.engine.news.until(lambda: "connected" in viewer.states)
        outgoing = viewer.connection.sections["0"].outgoing
        assert outgoing is not None
        async with asyncio.timeout(PATIENCE), ColourBars(160, 90, 15, clock=clock).open() as bars:
            seen = asyncio.ensure_future(arriving.get())
            async for picture in bars:
                outgoing.put(picture)
                if seen.done():
                    break
        assert (seen.result().width, seen.result().height) == (160, 90)
        session.disconnect("up")
        await viewer.engine.news.until(lambda: len(viewer.engine.offers) == 2)
        await viewer.engine.until("up", StreamStatus.NOT_CONNECTED)


async def test_candidates_of_servers_follow_the_answer() -> None:
    found: list[str | None] = []
    servers = [IceServer(urls=("stun:127.0.0.1:9",))]
    async with engine() as one:
        connection = AnsweringConnection(SystemClock(), ice_servers=servers, on_candidate=found.append)
        try:
            one.connect("s", "video")
            await one.news.until(lambda: one.offers)
            answer = await connection.answer_offer(one.offers[0].sdp)
            assert "a=candidate:" in answer
            assert "a=end-of-candidates" not in answer
        finally:
            await connection.close()
            await connection.close()


async def test_what_cannot_be_applied_is_refused() -> None:
    async with far() as viewer:
        with pytest.raises(InvalidDescription):
            await viewer.connection.answer_offer("v=0\r\nm=nonsense\r\n")
        viewer.engine.connect("s", "video")
        await viewer.engine.until("s", StreamStatus.RUNNING)
        with pytest.raises(InvalidCandidate):
            await viewer.connection.add_candidate("candidate:nonsense")
        await viewer.connection.add_candidate("candidate:1 1 udp 1 hidden.local 4000 typ host")
        await viewer.connection.add_candidate(None)
