"""Pictures that a game engine has encoded itself, all the way to those who look."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import dataclass
from pathlib import Path

import pytest
from openrois_avatar.link.embedded import EmbeddedEngine
from openrois_avatar.link.messages import Event, Log
from openrois_streaming.clock import SystemClock
from openrois_streaming.publish.passthrough import EncodedPublisher
from openrois_streaming.testing import ImpairedPath, Impairments, MeasuringSink, playing

from tests.support import loopback
from tests.support.chromium import browser_at, tab
from tests.support.loopback import some_address

ENGINE = "tests.support.encoding_engine"
BACK = Impairments(delay=0.005)


@dataclass
class Stage:
    """An engine that runs, what it says, and what is published of it."""

    engine: EmbeddedEngine
    video: EncodedPublisher
    events: list[Event]

    def said(self, what: str) -> int:
        return sum(isinstance(event, Log) and event.text.startswith(what) for event in self.events)


@asynccontextmanager
async def encoding() -> AsyncIterator[Stage]:
    events: list[Event] = []
    clock = SystemClock()
    with some_address():
        async with EmbeddedEngine(ENGINE, on_event=events.append, clock=clock) as engine:
            shape = engine.encoded.announced
            assert shape is not None
            publisher = EncodedPublisher(
                engine.encoded, clock=clock, frame_rate=shape.fps, size=(shape.width, shape.height)
            )
            yield Stage(engine, publisher, events)
            assert publisher.running_encoders == 0


@pytest.fixture
async def stage() -> AsyncIterator[Stage]:
    async with encoding() as stage:
        yield stage


@pytest.mark.media
async def test_a_viewer_sees_what_the_engine_has_encoded(stage: Stage) -> None:
    async with MeasuringSink() as sink, playing(sink, video=stage.video):
        await sink.sees(45)
        assert sink.pictures().unreadable == 0
    (rendition,) = stage.video.made
    figures = rendition.figures()
    assert (figures.mime_type, figures.size) == ("video/H264", "320x180@30")
    assert stage.said("key frame") >= 1
    assert figures.starts >= 1
    assert stage.said("bitrate") >= 1


@pytest.mark.media
async def test_later_viewer_gets_a_key_frame_of_the_engine(stage: Stage) -> None:
    async with MeasuringSink() as first, playing(first, video=stage.video):
        await first.sees(10)
        asked = stage.said("key frame")
        async with MeasuringSink() as second, playing(second, video=stage.video):
            await second.sees(10)
        assert stage.said("key frame") > asked
        await first.sees(10)
        assert first.pictures().unreadable == 0


@pytest.mark.media
async def test_losses_are_repaired(stage: Stage) -> None:
    path = ImpairedPath(Impairments(delay=0.005), BACK)
    async with path, MeasuringSink(path=path) as sink, playing(sink, video=stage.video):
        await sink.sees(10)
        path.down.lose_next(40)
        await sink.sees(40)
        assert path.down.figures().lost == 40
        assert sink.pictures().unreadable == 0


@pytest.mark.media
async def test_another_engine_takes_over_and_the_picture_goes_on(stage: Stage) -> None:
    async with MeasuringSink() as sink, playing(sink, video=stage.video):
        await sink.sees(10)
        connection = stage.engine._server.engine
        assert connection is not None
        connection.abort("the engine is killed")
        sink.restart()
        await sink.sees(20)
        assert sink.pictures().unreadable == 0


@pytest.mark.browser
async def test_chromium_shows_it(chromium: Path) -> None:
    async with encoding() as stage, browser_at(chromium) as browser, loopback.engine() as engine:
        engine.video = stage.video  # type: ignore[assignment]
        async with tab(engine, browser) as page:
            engine.connect("v", "video")
            await page.plays("0")
            assert page.refusals == []
        await engine.close()
