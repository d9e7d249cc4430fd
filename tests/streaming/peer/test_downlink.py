import logging
from collections.abc import AsyncIterator, Callable
from random import Random

import pytest
from openrois_signaling.messages import MediaKind
from openrois_streaming.adaptation.budget import BURST, START
from openrois_streaming.adaptation.rung import ladder
from openrois_streaming.adaptation.viewer import VIDEO_SHARE, Caps
from openrois_streaming.encoded import EncodedFrame
from openrois_streaming.peer.downlink import Downlink
from openrois_streaming.peer.stream import Stream
from openrois_streaming.publish.key_frames import KeyFrameCause
from openrois_streaming.rtp.reports import ReceiverReport
from openrois_streaming.session.session import TICK
from openrois_streaming.stats import Counters
from openrois_streaming.tasks import OwnedTasks

from tests.support.streaming import VirtualClock, settle
from tests.support.viewing import FedPublisher, FedRendition, frame

BASE = 0.02


class Way:
    """A downlink to a viewer whose path carries so many bit/s; the test turns the clock."""

    def __init__(self, kind: MediaKind = "video", caps: Caps | None = None) -> None:
        self.clock = VirtualClock()
        self.publisher = FedPublisher()
        self.publisher.rung = ladder(320, 180, 30)[0] if kind == "video" else None
        self.codec = "video/VP8" if kind == "video" else "audio/opus"
        self.stream = Stream(
            "s", "engine/c", kind, self.publisher, (self.codec,), Counters(), caps=caps or Caps(max_bitrate=5_000_000)
        )
        self.tasks = OwnedTasks("test", lambda error: pytest.fail(repr(error)))
        self.carried = 100_000_000.0
        self.base = BASE
        self.jitter: Callable[[], float] = lambda: 0.0
        """Seconds by which the next packet is late by chance."""
        self.silent = False
        """Whether round trips have no answer."""
        self.padded: list[int] = []
        self.room = 1_000_000
        """Bytes that can be sent again at a time."""
        self.taken: list[int] = []
        self._burst = 0
        self.downlink = Downlink(self.stream, self, self.tasks, self.clock, self.round_trip)

    @property
    def rendition(self) -> FedRendition:
        return self.publisher.renditions(self.codec)[0]

    def send(self, frame: EncodedFrame) -> None:
        self.taken.append(frame.sequence)
        self.stream.counters.sent(frame)
        self.downlink.sent(frame)

    def pad(self, octets: int) -> int:
        sent = min(octets, self.room)
        self.padded.append(sent)
        self._burst += sent
        return sent

    async def round_trip(self) -> float | None:
        trip = self.base + self._burst * 8 / self.carried + self.jitter()
        await self.clock.sleep_until(self.clock.now() + trip)
        self._burst = 0
        return None if self.silent else trip

    async def live(self, seconds: float) -> None:
        for _ in range(round(seconds / TICK)):
            await self.clock.advance(TICK)
            self.downlink.tick(self.clock.now())
            await settle()


@pytest.fixture
async def way() -> AsyncIterator[Way]:
    way = Way()
    yield way
    way.downlink.close()
    await way.tasks.aclose()
    assert way.rendition.readers == 0


async def test_open_downlink_plays_with_the_viewers_demand(way: Way) -> None:
    assert (way.downlink.is_open, way.downlink.figures()) == (False, None)
    way.downlink.tick(way.clock.now())
    way.downlink.open("video/VP8")
    await settle()
    assert way.downlink.is_open
    await way.rendition.show(keyframe=True)
    assert way.taken == [0]
    assert way.rendition.demanded == START * VIDEO_SHARE
    way.downlink.repair()
    assert way.rendition.asked == [KeyFrameCause.START, KeyFrameCause.REPAIR]
    way.downlink.close()
    await settle()
    assert way.rendition.readers == 0


async def test_a_burst_shows_what_the_path_carries_and_the_stream_remembers_it(way: Way) -> None:
    way.downlink.open("video/VP8")
    await way.live(0.5)
    assert way.padded == [], "nothing is asked before the first picture"
    await way.rendition.show(keyframe=True)
    await way.live(0.5)
    wanted = way.rendition.rung.max_bitrate / VIDEO_SHARE  # type: ignore[union-attr]
    assert wanted < START, "a small picture needs no burst"
    assert way.padded == []
    figures = way.downlink.figures()
    assert figures is not None
    assert (figures.width, figures.height, figures.path, figures.probing) == (320, 180, START, False)


async def test_bursts_are_made_of_what_there_is_to_repeat_and_what_they_show_is_had() -> None:
    way = Way()
    way.publisher.rung = ladder(1280, 720, 30)[0]
    way.room = 6000
    way.downlink.open("video/VP8")
    await settle()
    await way.rendition.show(keyframe=True)
    await way.live(1)
    wanted = 2_500_000 / VIDEO_SHARE
    assert sum(way.padded) == pytest.approx(wanted * BURST / 8, rel=0.01)
    assert len(way.padded) == 3
    assert way.stream.path_bitrate == pytest.approx(wanted)
    assert way.rendition.demanded == pytest.approx(2_500_000)
    await _end(way)


@pytest.mark.parametrize("silent", [False, True])
async def test_a_path_that_carries_no_more_or_does_not_answer_is_asked_again_later(silent: bool) -> None:
    way = Way()
    way.publisher.rung = ladder(1280, 720, 30)[0]
    way.carried, way.silent = 1_000_000, silent
    way.downlink.open("video/VP8")
    await settle()
    await way.rendition.show(keyframe=True)
    await way.live(3)
    assert len(way.padded) == 1
    assert way.stream.path_bitrate is not None
    assert way.stream.path_bitrate <= START
    await way.live(3)
    assert len(way.padded) == 2
    await _end(way)


async def test_viewers_estimate_counts_unless_a_round_trip_disproves_it(way: Way) -> None:
    way.downlink.open("video/VP8")
    way.silent = True
    await settle()
    await way.rendition.show(keyframe=True)
    way.downlink.sent(frame(1, data=bytes(50_000)))
    way.downlink.reported(ReceiverReport(1, 0.0, 0, 0, 0.03))
    way.downlink.estimated(500_000)
    way.downlink.estimated(60_000)
    await way.live(0.2)
    figures = way.downlink.figures()
    assert figures is not None
    assert (figures.path, figures.estimate, figures.bitrate) == (60_000, 60_000, 51_000)
    assert way.rendition.demanded == 51_000


async def test_a_viewer_that_was_busy_is_sent_what_it_was_sent_before(way: Way) -> None:
    way.downlink.open("video/VP8")
    await settle()
    await way.rendition.show(keyframe=True)
    await way.live(1)
    before, padded = way.rendition.demanded, len(way.padded)
    way.downlink.sent(frame(1, data=bytes(50_000)))
    way.downlink.reported(ReceiverReport(1, 0.0, 0, 0, 0.03, 0.03))
    complaints: list[Callable[[], None]] = [lambda: way.downlink.estimated(60_000), lambda: report_delay(way)]
    for complain in complaints:
        complain()
        await way.live(0.3)
        assert way.rendition.demanded == before
    assert len(way.padded) == padded, "no burst is needed for that"


def report_delay(way: Way) -> None:
    way.downlink.reported(ReceiverReport(2, 0.0, 0, 0, 0.5, 0.5))


async def test_a_stream_that_is_resumed_waits_for_no_doubt(way: Way) -> None:
    way.silent = True
    way.downlink.open("video/VP8")
    await settle()
    await way.rendition.show(keyframe=True)
    way.downlink.sent(frame(1, data=bytes(50_000)))
    way.downlink.reported(ReceiverReport(1, 0.0, 0, 0, 0.03))
    way.downlink.estimated(500_000)
    way.downlink.estimated(60_000)
    assert way.downlink.adaptation.path.doubtful(way.clock.now())
    way.downlink.close()
    await settle()
    assert way.rendition.readers == 0
    way.downlink.open("video/VP8")
    await settle()
    assert way.rendition.readers == 1


async def test_reports_on_a_closed_stream_are_ignored(way: Way) -> None:
    way.downlink.open("video/VP8")
    await settle()
    await way.rendition.show(keyframe=True)
    way.downlink.sent(frame(1, data=bytes(50_000)))
    way.downlink.reported(ReceiverReport(1, 0.0, 0, 0, 0.03, 0.03))
    way.downlink.estimated(2_000_000)
    before = way.downlink.adaptation.path.budget
    way.downlink.close()
    way.downlink.estimated(60_000)
    report_delay(way)
    way.downlink.open("video/VP8")
    await settle()
    assert way.downlink.adaptation.path.budget == before
    assert way.rendition.demanded == before * VIDEO_SHARE


async def test_delay_by_a_standstill_is_no_complaint(way: Way) -> None:
    way.silent = True
    way.downlink.open("video/VP8")
    await settle()
    await way.rendition.show(keyframe=True)
    way.downlink.sent(frame(1, data=bytes(50_000)))
    way.downlink.reported(ReceiverReport(1, 0.0, 0, 0, 0.03, 0.03))
    await way.clock.advance(0.5)
    report_delay(way)
    way.downlink.estimated(60_000)
    await way.live(0.3)
    figures = way.downlink.figures()
    assert figures is not None
    assert figures.path == START


async def test_a_publisher_that_has_nothing_is_asked_again_and_said_once(
    way: Way, caplog: pytest.LogCaptureFixture
) -> None:
    way.publisher.failure = OSError("no such codec")
    with caplog.at_level(logging.WARNING, logger="openrois_streaming.peer.downlink"):
        way.downlink.open("video/VP8")
        await way.live(0.5)
    assert len(caplog.records) == 1
    way.publisher.failure = None
    await way.live(0.1)
    await way.rendition.show(keyframe=True)
    assert way.taken == [0]


async def test_sound_has_nothing_to_choose_and_is_not_measured() -> None:
    way = Way("audio")
    way.downlink.open("audio/opus")
    await settle()
    await way.rendition.show(keyframe=True)
    await way.live(5)
    assert (way.taken, way.padded, way.rendition.demanded, way.downlink.figures()) == ([0], [], None, None)
    await _end(way)


async def _end(way: Way) -> None:
    way.downlink.close()
    await way.tasks.aclose()
    assert way.rendition.readers == 0


@pytest.mark.parametrize("seed", range(20))
async def test_on_a_long_way_that_jitters_it_recovers_from_a_complaint_that_was_none(seed: int) -> None:
    """Each packet takes 0.6 s there and back, and up to 0.1 s more each way."""
    chance = Random(seed)
    way = Way()
    way.publisher.rung = ladder(1280, 720, 30)[0]
    way.base, way.jitter = 0.6, lambda: chance.uniform(0, 0.1) + chance.uniform(0, 0.1)
    way.downlink.open("video/VP8")
    await settle()
    await way.rendition.show(keyframe=True)
    await way.live(8)
    for estimate in (500_000, 60_000, 50_000):
        way.downlink.sent(frame(1, data=bytes(50_000)))
        way.downlink.reported(ReceiverReport(1, 0.0, 0, 0, 0.75, 0.75))
        way.downlink.estimated(estimate)
        await way.live(1)
    await way.live(60)
    assert way.stream.path_bitrate is not None
    assert way.stream.path_bitrate > 400_000
    await _end(way)
