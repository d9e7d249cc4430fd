import asyncio
from typing import Any

import numpy as np
import pytest
from openrois_streaming.codecs import CodecUnavailable
from openrois_streaming.publish.encoder_limit import ENCODERS_LIMIT, EncoderLimit
from openrois_streaming.publish.publisher import AudioPublisher, VideoPublisher
from openrois_streaming.publish.rendition_feed import RenditionFeed
from openrois_streaming.publish.video_encoder import VideoEncoder
from openrois_streaming.source import stamp
from openrois_streaming.source.fanout import SourceEnded
from openrois_streaming.source.source import RawAudio, RawVideo
from openrois_streaming.source.stamp import Stamp
from openrois_streaming.stats import Counters
from openrois_streaming.tasks import OwnedTasks

from tests.support.pictures import Decoder, Scene
from tests.support.streaming import FedSource, VirtualClock, picture, settle


@pytest.fixture
def clock() -> VirtualClock:
    return VirtualClock()


async def test_two_renditions_share_one_source_and_one_stamp(clock: VirtualClock) -> None:
    source: FedSource[RawVideo] = FedSource()
    publisher = VideoPublisher(source, clock=clock, stamp=True, max_bitrate=400_000)
    scene = Scene()
    assert (publisher.running_encoders, publisher.last_frame_at, publisher.made) == (0, None, ())
    h264, vp8 = publisher.renditions("video/H264")[0], publisher.renditions("video/vp8")[0]
    decoders = [Decoder("video/H264"), Decoder("video/VP8")]
    async with h264.subscribe() as first, vp8.subscribe() as second, h264.subscribe() as third:
        assert publisher.running_encoders == 2
        for number in range(5):
            captured_at, wall = clock.now(), clock.wall()
            await clock.advance(0.004)
            await source.feed(scene.picture(number, captured_at))
            assert publisher.last_frame_at == clock.now()
            async with asyncio.timeout(60):
                frames = [await first.get(), await second.get()]
                assert await third.get() is frames[0], "encoded once, the same for all"
            for decoder, frame in zip(decoders, frames, strict=True):
                [plane] = decoder.decode(frame.data)
                assert stamp.read(plane) == Stamp.at(number, wall), "the time of capture, not of sending"
                assert frame.captured_at == captured_at
            await clock.advance(0.03)
        assert source.opened == 1
        assert publisher.frames == 5
    assert publisher.running_encoders == 0
    assert publisher.made == (h264, vp8)


async def test_a_picture_is_not_stamped_unless_that_is_wanted(clock: VirtualClock) -> None:
    source: FedSource[RawVideo] = FedSource()
    publisher = VideoPublisher(source, clock=clock)
    async with publisher.renditions("video/H264")[0].subscribe() as viewer:
        raw = picture(0, clock.now())
        await source.feed(raw)
        async with asyncio.timeout(60):
            await viewer.get()
        assert np.all(raw.data == 128)


async def test_a_picture_too_small_for_its_stamp_goes_without(clock: VirtualClock) -> None:
    source: FedSource[RawVideo] = FedSource()
    publisher = VideoPublisher(source, clock=clock, stamp=True)
    async with publisher.renditions("video/H264")[0].subscribe() as viewer:
        raw = picture(0, clock.now(), width=80)
        await source.feed(raw)
        async with asyncio.timeout(60):
            await viewer.get()
        assert np.all(raw.data == 128)


async def test_a_source_that_was_opened_anew_has_to_advance_anew(clock: VirtualClock) -> None:
    source: FedSource[RawVideo] = FedSource()
    publisher = VideoPublisher(source, clock=clock)
    async with publisher.renditions("video/VP8")[0].subscribe():
        await source.feed(picture(0, clock.now()))
        advanced = publisher.last_frame_at
    assert advanced == clock.now()
    async with publisher.renditions("video/VP8")[0].subscribe() as viewer:
        await source.feed(picture(1, clock.now()))
        async with asyncio.timeout(60):
            await viewer.get()
        await source.end(OSError())
    async with publisher.renditions("video/VP8")[0].subscribe():
        await clock.advance(0)
        assert publisher.last_frame_at is None
        assert publisher.frames == 2


async def test_encoder_failure_is_not_reported_as_an_earlier_source_failure(
    clock: VirtualClock, monkeypatch: pytest.MonkeyPatch
) -> None:
    source: FedSource[RawVideo] = FedSource()
    publisher = VideoPublisher(source, clock=clock)
    rendition = publisher.renditions("video/VP8")[0]
    with rendition.wanted():
        async with rendition.subscribe() as viewer:
            await source.end(OSError("unplugged"))
            async with asyncio.timeout(60):
                with pytest.raises(SourceEnded):
                    await viewer.get()
        assert publisher.failure == "the source of video has failed: unplugged"
    monkeypatch.setattr("openrois_streaming.publish.encoding.MAX_ABANDONED", 0)
    with rendition.wanted():
        async with rendition.subscribe() as viewer:
            async with asyncio.timeout(60):
                with pytest.raises(SourceEnded):
                    await viewer.get()
        told = "the encoder of video (video/VP8) has failed: 0 encoders hang: restart the adapter"
        assert publisher.failure == told


async def test_a_source_that_fails_again_for_one_viewer_has_not_become_an_encoder_for_another(
    clock: VirtualClock,
) -> None:
    source: FedSource[RawVideo] = FedSource()
    publisher = VideoPublisher(source, clock=clock)
    first, second = publisher.renditions("video/VP8")[0], publisher.renditions("video/H264")[0]
    with first.wanted(), second.wanted():
        for rendition, failure in ((first, "unplugged"), (second, "busy")):
            async with rendition.subscribe() as viewer:
                await source.end(OSError(failure))
                async with asyncio.timeout(60):
                    with pytest.raises(SourceEnded):
                        await viewer.get()
        assert publisher.failure == "the source of video has failed: busy"


async def test_a_source_that_fails_for_viewers_of_two_codecs_says_nothing_of_either(clock: VirtualClock) -> None:
    source: FedSource[RawVideo] = FedSource()
    publisher = VideoPublisher(source, clock=clock)
    codecs = ("video/VP8", "video/H264")
    renditions = [publisher.renditions(codec)[0] for codec in codecs]
    with renditions[0].wanted(), renditions[1].wanted():
        for number in range(10):
            for rendition in renditions:
                async with rendition.subscribe() as viewer:
                    await source.end(OSError(number))
                    async with asyncio.timeout(60):
                        with pytest.raises(SourceEnded):
                            await viewer.get()
                await clock.advance(0.5)
                assert [publisher.can_encode(codec) for codec in codecs] == [True, True]


async def test_a_codec_whose_encoders_fail_again_and_again_is_known(
    clock: VirtualClock, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(_encoder: VideoEncoder, mime_type: str, **_options: Any) -> None:
        raise MemoryError(mime_type)

    monkeypatch.setattr(VideoEncoder, "__init__", fail)
    source: FedSource[RawVideo] = FedSource()
    publisher = VideoPublisher(source, clock=clock)
    rendition = publisher.renditions("video/H264")[0]
    usable = []
    with rendition.wanted():
        for _ in range(4):
            async with rendition.subscribe() as viewer, asyncio.timeout(60):
                await source.feed(picture(0))
                with pytest.raises(SourceEnded):
                    await viewer.get()
            usable.append(publisher.can_encode("video/H264"))
            await clock.advance(1.0)
    assert usable == [True, True, False, False]
    assert publisher.can_encode("video/VP8")


def test_there_is_one_rendition_of_each_codec(clock: VirtualClock) -> None:
    publisher = VideoPublisher(FedSource[RawVideo](), clock=clock)
    rendition = publisher.renditions("video/H264")[0]
    assert publisher.renditions("VIDEO/h264")[0] is rendition
    assert (rendition.mime_type, rendition.clock_rate) == ("video/H264", 90_000)


def test_a_codec_that_is_not_there_or_not_for_this_is_refused(clock: VirtualClock) -> None:
    video = VideoPublisher(FedSource[RawVideo](), clock=clock)
    audio = AudioPublisher(FedSource[RawAudio](), clock=clock)
    with pytest.raises(CodecUnavailable, match="video/AV1"):
        video.renditions("video/AV1")[0]
    with pytest.raises(CodecUnavailable, match="audio/opus is no video codec"):
        video.renditions("audio/opus")[0]
    with pytest.raises(CodecUnavailable, match="video/VP8 is no audio codec"):
        audio.renditions("video/VP8")[0]


async def test_sound_is_encoded_once_for_all(clock: VirtualClock) -> None:
    source: FedSource[RawAudio] = FedSource()
    publisher = AudioPublisher(source, clock=clock)
    rendition = publisher.renditions("audio/opus")[0]
    async with rendition.subscribe() as first, rendition.subscribe() as second:
        assert publisher.running_encoders == 1
        for number in range(3):
            await source.feed(RawAudio(np.zeros((960, 1), np.int16), clock.now() + number / 50))
            async with asyncio.timeout(60):
                frame = await first.get()
                assert await second.get() is frame
            assert frame.pts == round(clock.now() * 48_000) + 960 * number
            assert (frame.clock_rate, frame.keyframe, frame.sequence) == (48_000, True, number)
    assert rendition.figures().dropped_input == 0


async def test_the_sizes_of_a_source_are_those_of_its_pictures_as_soon_as_there_are_any(clock: VirtualClock) -> None:
    source: FedSource[RawVideo] = FedSource()
    publisher = VideoPublisher(source, clock=clock, size=(640, 360), max_bitrate=1_000_000)

    def sizes(fps: float | None = None) -> list[tuple[int, int, float]]:
        rungs = [each.rung for each in publisher.renditions("video/H264", fps)]
        return [(rung.width, rung.height, rung.frame_rate) for rung in rungs if rung is not None]

    assert sizes() == [(640, 360, 30), (320, 180, 30)]
    assert sizes(15) == [(640, 360, 15), (320, 180, 15)]
    best = publisher.renditions("video/H264")[0]
    async with best.subscribe() as viewer:
        await source.feed(picture(0, clock.now(), width=320, height=180))
        async with asyncio.timeout(60):
            await viewer.get()
    assert sizes() == [(320, 180, 30)]
    assert publisher.renditions("video/H264")[0] is best
    assert publisher.made == (best,)


async def test_half_the_frame_rate_skips_every_other_picture_for_that_viewer_alone(
    clock: VirtualClock,
) -> None:
    source: FedSource[RawVideo] = FedSource()
    publisher = VideoPublisher(source, clock=clock, size=(160, 90))
    [all_of_them], [half] = publisher.renditions("video/H264"), publisher.renditions("video/H264", 15)
    async with all_of_them.subscribe() as first, half.subscribe() as second:
        for number in range(8):
            await source.feed(picture(number, clock.now() + number / 30))
            async with asyncio.timeout(60):
                await first.get()
                if number % 2 == 0:
                    await second.get()
    assert all_of_them.figures().encoded == 8
    assert half.figures().encoded == 4


async def test_many_viewers_that_want_many_paces_share_a_few_encoders(clock: VirtualClock) -> None:
    source: FedSource[RawVideo] = FedSource()
    publisher = VideoPublisher(source, clock=clock, size=(640, 360))
    tasks = OwnedTasks("viewers", lambda error: pytest.fail(repr(error)))
    feeds: list[RenditionFeed] = []
    for number in range(64):
        codec, fps = ("video/H264", "video/VP8")[number % 2], 30 / (1 + number // 4 % 8)
        feed = RenditionFeed("video", lambda frame: None, Counters(), tasks, clock)
        feed.play(publisher.renditions(codec, fps)[number // 2 % 2], 300_000)
        feeds.append(feed)
    await settle()
    assert publisher.running_encoders == ENCODERS_LIMIT
    assert publisher.has_room("video/VP8")
    for feed in feeds:
        feed.close()
    await tasks.aclose()
    assert publisher.running_encoders == 0
    assert len(set(publisher.renditions("video/H264", 10))) == 2, "there is room again"


async def test_with_one_encoder_the_second_codec_finds_no_room(clock: VirtualClock) -> None:
    publisher = VideoPublisher(FedSource[RawVideo](), clock=clock, encoders=EncoderLimit(1))
    assert publisher.has_room("video/VP8")
    async with publisher.renditions("video/H264")[0].subscribe():
        assert publisher.has_room("video/H264")
        assert not publisher.has_room("video/VP8")
    assert publisher.has_room("video/VP8")
