"""Pictures that come encoded: what is passed on of them, and what their source is asked for."""

import asyncio
from collections.abc import AsyncIterator
from contextlib import AsyncExitStack, asynccontextmanager

import pytest
from openrois_streaming.codecs import CodecUnavailable
from openrois_streaming.encoded import EncodedFrame
from openrois_streaming.publish.key_frames import KeyFrameCause
from openrois_streaming.publish.passthrough import NO_KEY_FRAME, EncodedPublisher, SwitchingPublisher
from openrois_streaming.publish.publisher import VideoPublisher
from openrois_streaming.rtp.payloads import payloads_of
from openrois_streaming.source.fanout import SourceEnded
from openrois_streaming.source.source import EncodedVideo, RawVideo

from tests.support.streaming import FedSource, VirtualClock, settle

DATA = b"\0\0\0\1\x65key"


def picture(sequence: int, *, keyframe: bool = False, width: int = 320, at: float | None = None) -> EncodedVideo:
    return EncodedVideo(DATA, keyframe, width, 180, sequence, 1000 + sequence / 30 if at is None else at)


class FedEncoder(FedSource[EncodedVideo]):
    """An `EncodingSource` that remembers what it was asked for."""

    def __init__(self) -> None:
        super().__init__()
        self.asked: list[int | str] = []

    def request_key_frame(self) -> None:
        self.asked.append("key frame")

    def set_bitrate(self, bitrate: int) -> None:
        self.asked.append(bitrate)


class ForgetfulEncoder(FedEncoder):
    """An `EncodingSource` that begins anew whenever it is opened: what it was asked for before is forgotten."""

    @asynccontextmanager
    async def open(self) -> AsyncIterator[AsyncIterator[EncodedVideo]]:
        self.asked.clear()
        async with super().open() as pictures:
            yield pictures


class Stage:
    """A publisher of what the test feeds, with viewers."""

    def __init__(self, source: FedEncoder | None = None) -> None:
        self.clock = VirtualClock()
        self.source = source or FedEncoder()
        self.publisher = EncodedPublisher(self.source, clock=self.clock, size=(320, 180))
        (self.rendition,) = self.publisher.renditions("video/H264")
        self.frames: list[EncodedFrame] = []

    @asynccontextmanager
    async def viewer(self, name: str = "v", bitrate: float | None = None) -> AsyncIterator[None]:
        async with self.rendition.play(name, self.frames.append, bitrate):
            await settle()
            yield

    @property
    def numbers(self) -> list[int]:
        return [frame.sequence for frame in self.frames]

    @property
    def key_frames(self) -> int:
        return self.source.asked.count("key frame")


@pytest.mark.parametrize("turns", range(12))
async def test_a_viewer_that_resumes_while_the_source_closes_asks_for_a_key_frame(turns: int) -> None:
    """Whatever turn of the loop it comes in: the source may be asked while it still closes, and forget it."""
    stage = Stage(ForgetfulEncoder())
    async with AsyncExitStack() as suspended:
        await suspended.enter_async_context(stage.viewer())
        await stage.source.feed(picture(0, keyframe=True))
        await stage.clock.advance(1)
        leaving = asyncio.create_task(suspended.aclose())
        for _ in range(turns):
            await asyncio.sleep(0)
        async with stage.rendition.play("resumed", stage.frames.append):
            await leaving
            await settle()
            await stage.clock.advance(1)
            await stage.source.feed(picture(1), picture(2))
            assert stage.key_frames >= 1


async def test_pictures_are_passed_on_with_their_times_and_cut_into_packets() -> None:
    stage = Stage()
    async with stage.viewer():
        await stage.source.feed(picture(7, keyframe=True), picture(8))
    first, second = stage.frames
    assert (first.data, first.payloads, first.keyframe, first.sequence) == (DATA, (b"\x65key",), True, 0)
    assert (first.pts, second.pts - first.pts) == (round((1000 + 7 / 30) * 90_000), 3000)
    assert (second.keyframe, second.sequence, second.clock_rate) == (False, 1, 90_000)
    figures = stage.rendition.figures()
    assert (figures.encoded, figures.encoded_bytes, figures.key_frames, figures.dropped_input) == (
        2,
        2 * len(DATA),
        1,
        0,
    )
    assert (figures.encode_seconds, figures.size) == (0, "320x180@30")


async def test_source_is_open_only_with_viewers_and_asked_for_a_key_frame() -> None:
    stage = Stage()
    stage.rendition.request_key_frame(KeyFrameCause.REPAIR)
    assert (stage.source.opened, stage.source.asked) == (0, [])
    async with stage.viewer():
        assert stage.source.is_open
        assert stage.key_frames == 1
    assert not stage.source.is_open


async def test_nothing_is_passed_on_before_a_key_frame_or_after_a_gap() -> None:
    stage = Stage()
    async with stage.viewer():
        await stage.source.feed(picture(0), picture(1, keyframe=True), picture(2))
        asked = stage.key_frames
        await stage.source.feed(picture(4))
        assert stage.key_frames == asked + 1
        await stage.source.feed(picture(5), picture(6, keyframe=True), picture(7))
    assert [frame.captured_at for frame in stage.frames] == [1000 + number / 30 for number in (1, 2, 6, 7)]
    assert stage.numbers == [0, 1, 2, 3]
    assert stage.rendition.figures().dropped_input == 3


async def test_key_frames_are_asked_for_as_often_as_the_budgets_allow() -> None:
    stage = Stage()
    async with stage.viewer():
        await stage.source.feed(picture(0, keyframe=True))
        for _ in range(5):
            stage.rendition.request_key_frame(KeyFrameCause.REPAIR)
        assert stage.key_frames == 2
        async with stage.viewer("other"):
            assert stage.key_frames == 2  # a start so soon after another one waits
            await stage.clock.advance(0.1)
            await stage.source.feed(picture(1))
            assert stage.key_frames == 3
        await stage.source.feed(picture(2, keyframe=True))
        assert stage.rendition.figures().starts == 2
        assert stage.rendition.figures().repairs == 1


async def test_unrequested_key_frame_serves_waiting_viewers() -> None:
    stage = Stage()
    async with stage.viewer():
        await stage.source.feed(picture(0, keyframe=True))
        stage.rendition.request_key_frame(KeyFrameCause.START)
        await stage.source.feed(picture(1, keyframe=True))
        await stage.clock.advance(1)
        await stage.source.feed(picture(2))
        assert stage.key_frames == 1


async def test_the_source_is_asked_for_what_the_slowest_viewer_can_take() -> None:
    stage = Stage()
    async with stage.viewer("fast", 600_000):
        assert stage.source.asked[0] == stage.rendition.figures().bitrate
        async with stage.viewer("slow", 100_000):
            assert stage.source.asked[-1] == "key frame" or stage.source.asked[-1] == 100_000
            assert 100_000 in stage.source.asked
            asked = len(stage.source.asked)
            stage.rendition.demand("slow", 105_000)
            assert len(stage.source.asked) == asked
    rung = stage.rendition.rung
    assert rung is not None
    assert rung.min_bitrate == 50_000


async def test_times_never_stand_still() -> None:
    stage = Stage()
    async with stage.viewer():
        await stage.source.feed(*(picture(number, keyframe=True, at=1000.0) for number in range(3)))
    assert [frame.pts for frame in stage.frames] == [90_000_000, 90_000_001, 90_000_002]


async def test_source_failure_is_reported() -> None:
    stage = Stage()
    assert (stage.publisher.failure, stage.publisher.made, stage.publisher.running_encoders) == ("", (), 0)
    async with stage.viewer():
        await stage.source.feed(picture(0, keyframe=True))
        assert (stage.publisher.frames, stage.publisher.last_frame_at) == (1, 1000.0)
        assert stage.publisher.running_encoders == 1
        await stage.source.end(OSError("gone"))
        assert stage.publisher.failure == "the source of video has failed: gone"
    assert stage.publisher.made == (stage.rendition,)


async def test_a_source_without_key_frames_fails() -> None:
    stage = Stage()
    async with stage.rendition.play("v", stage.frames.append) as playing:
        await settle()
        for number in range(NO_KEY_FRAME):
            await stage.source.feed(picture(number))
            await stage.clock.advance(1.0)
        assert not stage.publisher.failure
        await stage.source.feed(picture(NO_KEY_FRAME))
        with pytest.raises(SourceEnded):
            await playing.get()
        assert "no key frame in 10 s: let the encoder give one every two seconds" in stage.publisher.failure


async def test_a_source_may_wait_long_with_its_next_picture_but_not_with_a_key_frame() -> None:
    stage = Stage()
    async with stage.viewer():
        await stage.source.feed(picture(0, keyframe=True))
        for number in range(2, 6):  # after a gap
            await stage.clock.advance(NO_KEY_FRAME - 1 if number in (2, 5) else 0.1)
            await stage.source.feed(picture(number, keyframe=number == 4))
        assert not stage.publisher.failure
        assert stage.numbers == [0, 1, 2]


async def test_the_rendition_follows_the_size_of_the_pictures_and_what_is_announced() -> None:
    stage = Stage()
    async with stage.viewer():
        await stage.source.feed(picture(0, keyframe=True, width=640))
        assert stage.publisher.renditions("video/h264")[0].figures().size == "640x180@30"
        stage.publisher.expect(60, (1280, 720))
        assert stage.publisher.renditions("video/H264")[0].figures().size == "1280x720@60"


async def test_vp8_is_passed_on_in_packets_of_vp8() -> None:
    source, frames, data = FedEncoder(), list[EncodedFrame](), b"\x10\x00\x00\x9d\x01\x2a" + bytes(20)
    publisher = EncodedPublisher(source, clock=VirtualClock(), mime_type="video/vp8", size=(320, 180))
    assert publisher.codecs() == ("video/VP8",)
    (rendition,) = publisher.renditions("video/VP8")
    async with rendition.play("v", frames.append, None):
        await source.feed(EncodedVideo(data, True, 320, 180, 0, 1000))
    assert frames[0].payloads == payloads_of("video/VP8", data)
    with pytest.raises(CodecUnavailable, match="encoded as video/VP8 already"):
        publisher.renditions("video/H264")


def test_other_codecs_cannot_be_passed_on() -> None:
    with pytest.raises(CodecUnavailable, match="'video/AV1' cannot be passed on: use video/H264 or video/VP8"):
        EncodedPublisher(FedEncoder(), clock=VirtualClock(), mime_type="video/AV1")


def test_there_is_no_other_media_type() -> None:
    with pytest.raises(CodecUnavailable, match="encoded as video/H264 already"):
        Stage().publisher.renditions("video/VP8")


async def test_one_publisher_for_both_kinds() -> None:
    stage, raw = Stage(), FedSource[RawVideo]()
    encoded = [False]
    pixels = VideoPublisher(raw, clock=stage.clock, size=(320, 180))
    either = SwitchingPublisher(pixels, stage.publisher, lambda: encoded[0])
    assert either.codecs() is None
    assert either.renditions("video/VP8")[0].mime_type == "video/VP8"
    assert (either.last_frame_at, either.frames, either.failure, either.made, either.running_encoders) == (
        None,
        0,
        "",
        (),
        0,
    )
    encoded[0] = True
    assert either.codecs() == ("video/H264",)
    assert either.renditions("video/H264") == (stage.rendition,)
    with pytest.raises(CodecUnavailable):
        either.renditions("video/VP8")
    async with stage.viewer():
        await stage.source.feed(picture(0, keyframe=True))
        assert (either.last_frame_at, either.frames, either.running_encoders) == (1000.0, 1, 1)
    assert either.made == (stage.rendition,)
    either.expect(25, (640, 360))
    encoded[0] = False
    assert either.renditions("video/H264")[0].figures().size == "640x360@25"
