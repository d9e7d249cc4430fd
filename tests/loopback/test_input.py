"""What a person does, over real WebRTC: from an application's hands to the session that it plays with."""

import asyncio
import json

import pytest
from openrois_streaming.clock import SystemClock
from openrois_streaming.input.messages import Held, Key, State
from openrois_streaming.input.reader import Label
from openrois_streaming.publish.publisher import VideoPublisher
from openrois_streaming.synthetic import ColourBars
from openrois_streaming.testing import MeasuringSink
from openrois_streaming.testing.input_sender import InputSender
from openrois_streaming.testing.stage import playing

pytestmark = pytest.mark.media


class Ears:
    """Hears what comes over the data channels of a session."""

    def __init__(self) -> None:
        self.came: list[tuple[Label, str | bytes]] = []
        self.lost: list[str] = []
        self.news = asyncio.Event()

    def input_came(self, label: Label, data: str | bytes) -> None:
        self.came.append((label, data))
        self.news.set()

    def input_lost(self, reason: str) -> None:
        self.lost.append(reason)
        self.news.set()

    async def hear(self, count: int) -> None:
        async with asyncio.timeout(60):
            while len(self.came) < count:
                self.news.clear()
                await self.news.wait()


def bars() -> VideoPublisher:
    clock = SystemClock()
    return VideoPublisher(ColourBars(160, 90, clock=clock), clock=clock, stamp=True)


async def sender_of(sink: MeasuringSink) -> InputSender:
    await sink.until(lambda: sink.input is not None and sink.input.are_open)
    assert sink.input is not None
    return sink.input


async def test_messages_arrive_beside_the_pictures_and_answers_come_back() -> None:
    ears = Ears()
    async with MeasuringSink() as sink, playing(sink, video=bars(), inputs=ears) as session:
        await sink.sees()
        sender = await sender_of(sink)
        state, key = State(1, 0.0, Held(frozenset({"KeyW"}))), Key(2, 0.0, "KeyW", True)
        sender.send_message(state)
        await ears.hear(1)
        sender.send_message(key)
        sender.send(b"bytes", over_control=True)
        await ears.hear(3)
        assert ears.came == [
            ("input", json.dumps(state.to_json())),
            ("control", json.dumps(key.to_json())),
            ("control", b"bytes"),
        ]
        session.input.send_message("hello")
        await sink.until(lambda: sender.received == ["hello"])
        assert len(session.peer_ids) == 1
    assert ears.lost == ["the session is over"]


async def test_a_later_wish_is_offered_and_a_later_stream_too() -> None:
    ears = Ears()
    async with MeasuringSink() as sink, playing(sink, video=bars()) as session:
        await sink.sees()
        assert sink.input is None
    async with MeasuringSink() as sink, playing(sink, video=bars(), inputs=ears) as session:
        sender = await sender_of(sink)
        session.connect("second", "stage/Second", bars(), "video")
        await sink.sees(mid="2")
        sender.send_message(State(1, 0.0))
        await ears.hear(1)


async def test_end_of_the_other_side_is_notified() -> None:
    ears = Ears()
    async with MeasuringSink() as sink, playing(sink, video=bars(), inputs=ears):
        await sender_of(sink)
        await sink.__aexit__()
        async with asyncio.timeout(60):
            while not ears.lost:
                ears.news.clear()
                await ears.news.wait()
    assert ears.lost[0] in {"the application closed the peer connection", "the application closed its data channels"}
