from collections.abc import AsyncIterator

import pytest
from openrois_media.health import Health, Observed
from openrois_media.metrics.collector import Collector
from openrois_media.supervision import Supervised, seen_of
from openrois_streaming.errors import UnknownStream
from openrois_streaming.network.guard import GuardFigures
from openrois_streaming.network.session_limits import SESSIONS_LIMIT
from openrois_streaming.publish.publisher import VideoPublisher
from openrois_streaming.session.session import StreamSession
from openrois_streaming.session.sessions import StreamSessions
from openrois_streaming.source.source import RawVideo
from openrois_streaming.state import StreamStatus

from openrois.types.codes import ComponentStatus
from tests.support.streaming import FedSource, VirtualClock, picture, settle
from tests.support.viewing import Application, FedPublisher, WirelessConnection


@pytest.fixture
async def sessions(monkeypatch: pytest.MonkeyPatch) -> AsyncIterator[StreamSessions]:
    WirelessConnection.stand_in(monkeypatch)
    async with StreamSessions(lambda client_id: Application().session) as sessions:
        yield sessions


async def test_a_snapshot_holds_what_lives_now(sessions: StreamSessions) -> None:
    clock, source = VirtualClock(), FedSource[RawVideo]()
    publisher = VideoPublisher(source, clock=clock)
    health = Health("the picture", clock.now())
    supervised = Supervised(health, lambda: seen_of(publisher), ())
    idle = Supervised(Health("the sound", clock.now()), lambda: Observed(None, wanted=False), ())
    looking = Collector(sessions, {"picture": publisher}, {"picture": supervised, "sound": idle}, GuardFigures(), clock)

    empty = await looking.snapshot()
    assert (empty.streams, empty.renditions, empty.process.sessions) == ((), (), 0)

    alice = sessions.open("alice")
    alice.connect("a", "engine/Video", FedPublisher(), "video")
    sessions.open("bob")
    async with publisher.renditions("video/VP8")[-1].subscribe() as viewer:
        await source.feed(picture(0, clock.now()))
        await viewer.get()
        await clock.advance(0.25)
        seen = await looking.snapshot()
    assert [(stream.stream_id, stream.status) for stream in seen.streams] == [("a", StreamStatus.NOT_CONNECTED)]
    assert [(name, figures.viewers, figures.encoded) for name, figures in seen.renditions] == [("picture", 1, 1)]
    assert (seen.process.sessions, seen.process.sessions_limit) == (1, SESSIONS_LIMIT)
    assert seen.process.tasks > 1
    shown, heard = seen.sources
    assert (shown.name, shown.status, shown.frames) == ("picture", ComponentStatus.READY, 1)
    assert shown.last_frame_age == pytest.approx(0.25)
    assert heard.last_frame_age is None
    assert (shown.encoders, heard.encoders) == (1, None)

    alice.disconnect("a")
    await settle()
    assert (await looking.snapshot()).streams == ()


async def test_a_stream_that_ends_meanwhile_is_left_out(
    sessions: StreamSessions, monkeypatch: pytest.MonkeyPatch
) -> None:
    sessions.open("alice").connect("a", "engine/Video", FedPublisher(), "video")

    async def gone(_self: StreamSession, _stream_id: str) -> None:
        raise UnknownStream

    monkeypatch.setattr(StreamSession, "stats", gone)
    assert (await Collector(sessions, {}, {}, GuardFigures(), VirtualClock()).snapshot()).streams == ()
