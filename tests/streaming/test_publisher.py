import asyncio

import numpy as np
import pytest
from openrois_streaming import stamp
from openrois_streaming.codecs import CodecUnavailable
from openrois_streaming.fanout import SourceEnded
from openrois_streaming.publisher import AudioPublisher, VideoPublisher
from openrois_streaming.source import RawAudio, RawVideo
from openrois_streaming.stamp import Stamp

from tests.support.pictures import Decoder, Scene
from tests.support.streaming import FedSource, VirtualClock, picture


@pytest.fixture
def clock() -> VirtualClock:
    return VirtualClock()


async def test_two_renditions_share_one_source_and_one_stamp(clock: VirtualClock) -> None:
    source: FedSource[RawVideo] = FedSource()
    publisher = VideoPublisher(source, clock=clock, stamp=True, bitrate=400_000)
    scene = Scene()
    assert (publisher.running_encoders, publisher.last_frame_at, publisher.renditions) == (0, None, ())
    h264, vp8 = publisher.rendition("video/H264"), publisher.rendition("video/vp8")
    decoders = [Decoder("video/H264"), Decoder("video/VP8")]
    async with h264.subscribe() as first, vp8.subscribe() as second, h264.subscribe() as third:
        assert publisher.running_encoders == 2
        for number in range(5):
            captured_at, wall = clock.now(), clock.wall()
            await clock.advance(0.004)
            await source.feed(scene.picture(number, captured_at))
            assert publisher.last_frame_at == clock.now()
            async with asyncio.timeout(5):
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
    assert publisher.renditions == (h264, vp8)


async def test_a_picture_is_not_stamped_unless_that_is_wanted(clock: VirtualClock) -> None:
    source: FedSource[RawVideo] = FedSource()
    publisher = VideoPublisher(source, clock=clock)
    async with publisher.rendition("video/H264").subscribe() as viewer:
        raw = picture(0, clock.now())
        await source.feed(raw)
        async with asyncio.timeout(5):
            await viewer.get()
        assert np.all(raw.data == 128)


async def test_a_picture_too_small_for_its_stamp_fails_the_source(clock: VirtualClock) -> None:
    source: FedSource[RawVideo] = FedSource()
    publisher = VideoPublisher(source, clock=clock, stamp=True)
    async with publisher.rendition("video/H264").subscribe() as viewer:
        await source.feed(picture(0, clock.now(), width=80))
        with pytest.raises(SourceEnded) as told:
            await viewer.get()
        assert "too small" in str(told.value.__cause__)


async def test_a_source_that_was_opened_anew_has_to_advance_anew(clock: VirtualClock) -> None:
    source: FedSource[RawVideo] = FedSource()
    publisher = VideoPublisher(source, clock=clock)
    async with publisher.rendition("video/VP8").subscribe():
        await source.feed(picture(0, clock.now()))
        advanced = publisher.last_frame_at
    assert advanced == clock.now()
    async with publisher.rendition("video/VP8").subscribe() as viewer:
        await source.feed(picture(1, clock.now()))
        async with asyncio.timeout(5):
            await viewer.get()
        await source.end(OSError())
    async with publisher.rendition("video/VP8").subscribe():
        await clock.advance(0)
        assert publisher.last_frame_at is None
        assert publisher.frames == 2


def test_there_is_one_rendition_of_each_codec(clock: VirtualClock) -> None:
    publisher = VideoPublisher(FedSource[RawVideo](), clock=clock)
    rendition = publisher.rendition("video/H264")
    assert publisher.rendition("VIDEO/h264") is rendition
    assert (rendition.mime_type, rendition.clock_rate) == ("video/H264", 90_000)


def test_a_codec_that_is_not_there_or_not_for_this_is_refused(clock: VirtualClock) -> None:
    video = VideoPublisher(FedSource[RawVideo](), clock=clock)
    audio = AudioPublisher(FedSource[RawAudio](), clock=clock)
    with pytest.raises(CodecUnavailable, match="video/AV1"):
        video.rendition("video/AV1")
    with pytest.raises(CodecUnavailable, match="pictures cannot be encoded as audio/opus"):
        video.rendition("audio/opus")
    with pytest.raises(CodecUnavailable, match="sound cannot be encoded as video/VP8"):
        audio.rendition("video/VP8")


async def test_sound_is_encoded_once_for_all(clock: VirtualClock) -> None:
    source: FedSource[RawAudio] = FedSource()
    publisher = AudioPublisher(source, clock=clock)
    rendition = publisher.rendition("audio/opus")
    async with rendition.subscribe() as first, rendition.subscribe() as second:
        assert publisher.running_encoders == 1
        for number in range(3):
            await source.feed(RawAudio(np.zeros((960, 1), np.int16), clock.now() + number / 50))
            async with asyncio.timeout(5):
                frame = await first.get()
                assert await second.get() is frame
            assert frame.pts == round(clock.now() * 48_000) + 960 * number
            assert (frame.clock_rate, frame.keyframe, frame.sequence) == (48_000, True, number)
    assert rendition.figures().dropped_input == 0
