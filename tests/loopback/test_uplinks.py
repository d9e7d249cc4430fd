"""What an application sends arrives, with real media between it and a session."""

import asyncio
import threading
from collections.abc import AsyncIterator

import pytest
from aiortc import RTCSessionDescription
from openrois_signaling.messages import Offer
from openrois_streaming.clock import SystemClock
from openrois_streaming.source.loudness import LevelMeter
from openrois_streaming.source.shared_inlet import SharedInlet
from openrois_streaming.source.source import RawAudio, RawVideo
from openrois_streaming.state import StreamStatus
from openrois_streaming.synthetic import ColourBars, Tone

from tests.support import loopback
from tests.support.loopback import Engine, Viewer
from tests.support.receiving import SourceTrack

pytestmark = pytest.mark.media


class Talker(Viewer):
    """An application on aiortc that sends a tone and bars wherever it is asked to, but for the streams it declines."""

    def __init__(self, engine: Engine) -> None:
        super().__init__(engine)
        self.declines: set[str] = set()
        self.tracks: list[SourceTrack] = []

    async def respond(self, offer: Offer) -> None:
        connection = self.connections.get(offer.peer_id) or self._open(offer.peer_id)
        await connection.setRemoteDescription(RTCSessionDescription(offer.sdp, "offer"))
        by_mid = {each.mid: each for each in connection.getTransceivers()}
        for section in offer.streams:
            transceiver = by_mid[section.mid]
            if section.direction == "recvonly":
                continue
            if section.stream_id in self.declines:
                transceiver.direction = "recvonly" if section.direction == "sendrecv" else "inactive"
                continue
            if transceiver.sender.track is None:
                transceiver.sender.replaceTrack(self._track(section.kind))
            transceiver.direction = section.direction
        await connection.setLocalDescription(await connection.createAnswer())
        await self.engine.answer(offer, connection.localDescription.sdp)

    def _track(self, kind: str) -> SourceTrack:
        clock = SystemClock()
        self.tracks.append(
            SourceTrack(kind, ColourBars(320, 180, clock=clock) if kind == "video" else Tone(clock=clock))
        )
        return self.tracks[-1]

    async def close(self) -> None:
        await super().close()
        for track in self.tracks:
            await track.aclose()


class CarefulTalker(Talker):
    """Answers what is idle as the wire's page wants it, and lets go of the device as a person's application does."""

    async def respond(self, offer: Offer) -> None:
        connection = self.connections.get(offer.peer_id)
        carried = {each.mid for each in offer.streams}
        for transceiver in () if connection is None else connection.getTransceivers():
            track = transceiver.sender.track
            if transceiver.mid in carried or track is None:
                continue
            # In this order: aiortc ends the sender of a track that ends, and nothing begins it again.
            transceiver.sender.replaceTrack(None)
            track.stop()
            transceiver.direction = "inactive"
        await super().respond(offer)


class Ears:
    """The inlets of an engine."""

    def __init__(self, engine: Engine) -> None:
        self.engine = engine
        self.microphone: SharedInlet[RawAudio] = SharedInlet("microphone")
        self.camera: SharedInlet[RawVideo] = SharedInlet("camera")

    def connect(self, stream_id: str, kind: str = "audio", *, both: bool = False) -> None:
        session, audio = self.engine.session, self.engine.audio if both else None
        if kind == "video":
            session.connect(stream_id, "engine/Video", None, "video", direction="sendonly", inlet=self.camera)
        else:
            direction = "sendrecv" if both else "sendonly"
            session.connect(stream_id, "engine/Audio", audio, "audio", direction=direction, inlet=self.microphone)  # type: ignore[arg-type]

    async def pictures(self, count: int) -> list[RawVideo]:
        async with asyncio.timeout(loopback.PATIENCE), self.camera.subscribe(4) as pictures:
            return [await pictures.get() for _ in range(count)]

    async def until_heard(self, threshold: float = -40.0) -> float:
        """The first level above `threshold`, over 0.1 s."""
        async with asyncio.timeout(loopback.PATIENCE), self.microphone.subscribe(50) as blocks:
            meter = LevelMeter()
            while True:
                for _ in range(10):
                    meter.add((await blocks.get()).samples)
                level = meter.read()
                if level.rms > threshold:
                    return level.rms


@pytest.fixture
async def ears() -> AsyncIterator[Ears]:
    async with loopback.engine() as engine:
        ears = Ears(engine)
        yield ears
        assert engine.failures == []
    assert ears.microphone.stream_id is ears.camera.stream_id is None
    assert not [each for each in threading.enumerate() if each.name.startswith("decode")]


@pytest.fixture
async def talker(ears: Ears) -> AsyncIterator[Talker]:
    talker = Talker(ears.engine)
    yield talker
    await talker.close()


async def test_tone_and_pictures_arrive_are_suspended_and_go_on_over_a_replacement(ears: Ears, talker: Talker) -> None:
    engine = ears.engine
    engine.connect("v", "video")
    ears.connect("mic")
    ears.connect("cam", "video")
    for stream_id in ("v", "mic", "cam"):
        await engine.until(stream_id, StreamStatus.RUNNING)
    await talker.plays("0")
    assert -40 < await ears.until_heard() < -3
    seen = await ears.pictures(2)
    assert {(each.width, each.height) for each in seen} == {(320, 180)}
    assert seen[0].data[90, 20] > 150 > 60 > seen[0].data[90, 300]
    assert seen[0].captured_at < seen[1].captured_at
    engine.session.suspend("cam")
    engine.session.hold("engine/Audio")
    for stream_id in ("cam", "mic"):
        await engine.until(stream_id, StreamStatus.SUSPENDED)
    engine.session.restart("engine/p1")
    await engine.news.until(lambda: engine.byes)
    assert [engine.session.status(each) for each in ("cam", "mic")] == [StreamStatus.SUSPENDED] * 2
    engine.session.release("engine/Audio")
    engine.session.resume("cam")
    for stream_id in ("v", "mic", "cam"):
        await engine.until(stream_id, StreamStatus.RUNNING)
    assert await ears.until_heard() < -3
    assert await ears.pictures(1)
    engine.session.disconnect("cam")
    await engine.until("cam", StreamStatus.NOT_CONNECTED)
    assert ears.camera.stream_id is None
    ears.connect("cam2", "video")
    await engine.until("cam2", StreamStatus.RUNNING)
    assert await ears.pictures(1)
    assert [each.mid for each in engine.offers[-1].streams] == ["0", "1", "2"]


async def test_conversation_and_second_microphone_are_distinguished(ears: Ears, talker: Talker) -> None:
    other: SharedInlet[RawAudio] = SharedInlet("other")
    ears.connect("talk", both=True)
    ears.engine.session.connect("mic", "engine/Other", None, "audio", direction="sendonly", inlet=other)
    for stream_id in ("talk", "mic"):
        await ears.engine.until(stream_id, StreamStatus.RUNNING)
    await talker.plays("0")


async def test_declined_section_ends_or_narrows_that_stream_alone(ears: Ears, talker: Talker) -> None:
    talker.declines = {"mic", "talk"}
    engine = ears.engine
    engine.connect("v", "video")
    ears.connect("mic")
    ears.connect("talk", both=True)
    await engine.until("mic", StreamStatus.NOT_CONNECTED)
    for stream_id in ("v", "talk"):
        await engine.until(stream_id, StreamStatus.RUNNING)
    assert engine.byes == []
    assert ears.microphone.stream_id is None
    await talker.plays("0")
    await talker.plays("2")
    talker.declines = set()
    ears.connect("mic2")
    await engine.until("mic2", StreamStatus.RUNNING)
    await engine.until("talk", StreamStatus.RUNNING)
    assert await ears.until_heard() < -3
    assert engine.byes == []


@pytest.mark.parametrize("kind", ["video", "audio"])
async def test_a_device_that_is_let_go_is_connected_again_on_the_same_peer(ears: Ears, kind: str) -> None:
    engine, talker = ears.engine, CarefulTalker(ears.engine)
    try:
        for stream_id in ("one", "two", "three"):
            ears.connect(stream_id, kind)
            await engine.until(stream_id, StreamStatus.RUNNING)
            engine.session.disconnect(stream_id)
            await engine.until(stream_id, StreamStatus.NOT_CONNECTED)
        assert {each.mid for offer in engine.offers for each in offer.streams} == {"0"}
        assert len(talker.tracks) == 3
        assert len(talker.connections) == 1
    finally:
        await talker.close()


async def test_a_sender_of_aiortc_whose_track_ends_is_done_for_good(ears: Ears, talker: Talker) -> None:
    ears.connect("camera", "video")
    await ears.engine.until("camera", StreamStatus.RUNNING)
    (connection,) = talker.connections.values()
    [transceiver] = connection.getTransceivers()
    talker.tracks[0].stop()
    async with asyncio.timeout(loopback.PATIENCE):
        await vars(transceiver.sender)["_RTCRtpSender__rtp_exited"].wait()
    transceiver.sender.replaceTrack(talker._track("video"))
    await ears.engine.until("camera", StreamStatus.NOT_RUNNING)
    assert vars(transceiver.sender)["_RTCRtpSender__rtp_task"].done()
