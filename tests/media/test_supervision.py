import asyncio
import logging
from collections.abc import AsyncIterator

import pytest
from openrois_media.health import Health, Observed
from openrois_media.supervision import Supervised, seen_of, supervise
from openrois_streaming.encoded import EncodedFrame
from openrois_streaming.publish.publisher import VideoPublisher
from openrois_streaming.publish.rendition_feed import RenditionFeed
from openrois_streaming.source.fanout import SourceEnded
from openrois_streaming.source.source import RawVideo
from openrois_streaming.source.supervision import HUNG, QUIET
from openrois_streaming.stats import Counters
from openrois_streaming.tasks import OwnedTasks

from openrois.adapter.components import VideoStreaming
from openrois.types.codes import ComponentStatus, ErrorType
from tests.support.streaming import FakeEncoders, FedSource, VirtualClock, picture, settle
from tests.support.streams import Camera


class Post:
    """A source under supervision, on a clock that stands still."""

    def __init__(self) -> None:
        self.clock = VirtualClock()
        self.health = Health("the picture", self.clock.now())
        self.seen = Observed(self.clock.now())
        self.camera: VideoStreaming = Camera()
        self.reported: list[tuple[ErrorType, str]] = []
        self.camera.report = lambda kind, sentence: self.reported.append((kind, sentence))


@pytest.fixture
async def post() -> AsyncIterator[Post]:
    post = Post()
    supervised = Supervised(post.health, lambda: post.seen, (post.camera,))
    task = asyncio.create_task(supervise((supervised,), post.clock))
    await settle()
    yield post
    task.cancel()
    await asyncio.wait({task})


async def test_a_source_that_hangs_is_reported_by_its_components_and_its_return_is_logged(
    post: Post, caplog: pytest.LogCaptureFixture
) -> None:
    await post.clock.advance(QUIET + 0.3)
    assert (post.health.status, post.reported) == (ComponentStatus.WARNING, [])
    await post.clock.advance(HUNG - QUIET)
    assert post.health.status is ComponentStatus.ERROR
    assert post.reported == [(ErrorType.COMPONENT_NOT_RESPONDING, "the picture has given no frame for 5 s")]
    post.seen = Observed(post.clock.now())
    with caplog.at_level(logging.INFO):
        await post.clock.advance(0.3)
    assert caplog.messages == ["the picture has given no frame for 5 s", "the picture has recovered"]


async def test_stopped_adapter_reports_no_fault(post: Post) -> None:
    await post.clock.advance(0.5)
    post.clock.jump(20)
    await post.clock.advance(QUIET - 0.3)
    assert (post.health.status, post.reported) == (ComponentStatus.READY, [])


async def test_a_broken_source_is_reported_once_however_many_viewers_come_and_go(
    post: Post, caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level(logging.INFO)
    for _ in range(2):
        post.seen = Observed(None, failure="unplugged")
        await post.clock.advance(0.5)
        post.seen = Observed(None, wanted=False, unseen=True)
        await post.clock.advance(30)
    assert post.reported == [(ErrorType.COMPONENT_INTERNAL_ERROR, "unplugged")]
    assert caplog.messages == ["unplugged"]
    post.seen = Observed(post.clock.now())
    await post.clock.advance(0.3)
    assert caplog.messages == ["unplugged", "the picture has recovered"]


async def test_a_publisher_is_seen_to_play_to_stall_and_to_fail(monkeypatch: pytest.MonkeyPatch) -> None:
    clock, source, encoders = VirtualClock(), FedSource[RawVideo](), FakeEncoders()
    monkeypatch.setattr(
        "openrois_streaming.publish.publisher.VideoEncoder", lambda _, *, bitrate, **__: encoders(bitrate)
    )
    publisher = VideoPublisher(source, clock=clock, name="bars")
    assert seen_of(publisher) == Observed(None, wanted=False, unseen=True)
    rendition = publisher.renditions("video/H264")[0]
    async with rendition.subscribe() as viewer:
        await source.feed(picture(0))
        await viewer.get()
        assert seen_of(publisher) == Observed(clock.now(), frames=1)
        encoders.made[0].failure = ValueError("odd")
        await source.feed(picture(1))
        with pytest.raises(Exception, match="has ended"):
            await viewer.get()
        assert seen_of(publisher).failure == "the encoder of bars (video/H264) has failed: odd"
    async with rendition.subscribe() as viewer:
        await source.end(OSError("unplugged"))
        with pytest.raises(SourceEnded):
            await viewer.get()
        assert seen_of(publisher).failure == "the source of bars has failed: unplugged"
    async with rendition.subscribe() as viewer:
        await source.feed(picture(2))
        await viewer.get()
        assert seen_of(publisher).failure == ""


async def test_failed_encoder_is_no_fault_once_its_viewers_changed_codec(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    clock, source, encoders = VirtualClock(), FedSource[RawVideo](), FakeEncoders()
    monkeypatch.setattr(
        "openrois_streaming.publish.publisher.VideoEncoder", lambda _, *, bitrate, **__: encoders(bitrate)
    )
    publisher = VideoPublisher(source, clock=clock, size=(640, 360), name="bars")
    large, small = publisher.renditions("video/H264")
    shown: asyncio.Queue[EncodedFrame] = asyncio.Queue()
    tasks = OwnedTasks("test", lambda error: pytest.fail(repr(error)))
    feed = RenditionFeed("video", shown.put_nowait, Counters(), tasks, clock)

    async def show(number: int) -> None:
        await source.feed(picture(number, clock.now(), width=640, height=360))

    feed.play(large)
    async with asyncio.timeout(60), large.subscribe() as witness:
        await show(0)
        await witness.get()
        encoders.made[0].failure = ValueError("odd")
        await show(1)
        with pytest.raises(SourceEnded):
            await witness.get()
    assert "has failed: odd" in seen_of(publisher).failure, "the viewer is about to try it again"
    feed.play(small)
    await settle()
    await show(2)
    async with asyncio.timeout(60):
        assert [(await shown.get()).data for _ in range(2)] == [b"0", b"2"]
    assert seen_of(publisher).failure == ""
    feed.play(large)
    await settle()
    assert seen_of(publisher).failure == "", "it has not failed again"
    feed.close()
    await tasks.aclose()


async def test_failed_source_is_no_fault_while_unplayed() -> None:
    source = FedSource[RawVideo]()
    publisher = VideoPublisher(source, clock=VirtualClock())
    async with publisher.renditions("video/VP8")[0].subscribe() as viewer:
        await source.end(OSError("unplugged"))
        with pytest.raises(SourceEnded):
            await viewer.get()
        assert seen_of(publisher).failure == "the source of video has failed: unplugged"
    assert seen_of(publisher) == Observed(None, wanted=False, unseen=True)


async def test_a_source_that_cannot_be_opened_has_failed() -> None:
    source = FedSource[RawVideo]()
    source.refusal = OSError("busy")
    publisher = VideoPublisher(source, clock=VirtualClock())
    async with publisher.renditions("video/VP8")[0].subscribe() as viewer:
        with pytest.raises(SourceEnded):
            await viewer.get()
        assert seen_of(publisher).failure == "the source of video has failed: busy"
