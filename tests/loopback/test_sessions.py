"""What a session does, with real media between it and viewers on aiortc."""

import asyncio
import time
from collections.abc import Callable
from statistics import median

import pytest
import uvloop
from aiortc.rtp import AnyRtcpPacket, RtcpSenderInfo, RtcpSrPacket, RtpPacket
from openrois_streaming.errors import TooManySections
from openrois_streaming.state import StreamStatus

from tests.support import loopback
from tests.support.loopback import Engine, Viewer

pytestmark = pytest.mark.media


async def play_suspend_resume_replace_and_leave() -> None:
    async with loopback.engine() as engine, loopback.viewer(engine) as viewer:
        engine.connect("v", "video")
        engine.connect("a", "audio")
        await viewer.plays("0")
        await viewer.plays("1")
        await engine.until("v", StreamStatus.RUNNING)
        await engine.until("a", StreamStatus.RUNNING)
        engine.session.suspend("v")
        await engine.until("v", StreamStatus.SUSPENDED)
        sent = (await engine.session.stats("v")).frames_sent
        await viewer.plays("1", 10)
        assert (await engine.session.stats("v")).frames_sent == sent
        engine.session.resume("v")
        await viewer.plays("0")
        await engine.until("v", StreamStatus.RUNNING)
        assert engine.changes[-1].resumed
        assert len(engine.offers) == 1
        engine.session.restart("engine/p1")
        await engine.news.until(lambda: engine.byes)
        assert [(bye.peer_id, bye.reason) for bye in engine.byes] == [("engine/p1", "it was replaced")]
        await viewer.plays("0")
        assert engine.offers[-1].replaces == "engine/p1"
        assert StreamStatus.NOT_CONNECTED not in engine.statuses("v")
        stats = await engine.session.stats("v")
        assert stats.codec == "video/H264"
        assert stats.frames_sent > 10
        engine.session.disconnect("v")
        await engine.until("v", StreamStatus.NOT_CONNECTED)


@pytest.mark.parametrize("loop", [asyncio.new_event_loop, uvloop.new_event_loop])
def test_the_life_of_a_session_on_both_event_loops(loop: Callable[[], asyncio.AbstractEventLoop]) -> None:
    with asyncio.Runner(loop_factory=loop) as runner:
        runner.run(play_suspend_resume_replace_and_leave())


async def test_the_figures_of_a_stream_come_from_its_viewer(engine: Engine, viewer: Viewer) -> None:
    engine.connect("v", "video", ["VP8"])
    stats = await engine.session.stats("v")
    assert (stats.codec, stats.round_trip_time, stats.packets_lost) == (None, None, None)
    async with asyncio.timeout(loopback.PATIENCE):
        while stats.round_trip_time is None:
            await viewer.plays("0", 1)
            stats = await engine.session.stats("v")
    assert stats.codec == "video/VP8"
    assert 0 < stats.round_trip_time < loopback.PATIENCE
    assert (stats.packets_lost, stats.fraction_lost, stats.frames_dropped) == (0, 0.0, 0)
    assert stats.frames_sent >= viewer.frames["0"]
    assert stats.key_frames >= 1
    assert stats.bytes_sent > 1000


async def test_sender_reports_say_when_a_picture_was_captured(engine: Engine, viewer: Viewer) -> None:
    engine.source.delay = 0.1
    engine.connect("v", "video")
    await viewer.plays()
    (connection,) = viewer.connections.values()
    receiver = connection.getTransceivers()[0].receiver
    reports: list[RtcpSenderInfo] = []
    told: list[float] = []
    ages: list[float] = []
    handle_report, handle = receiver._handle_rtcp_packet, receiver._handle_rtp_packet

    async def report_watched(packet: AnyRtcpPacket) -> None:
        if isinstance(packet, RtcpSrPacket):
            reports.append(packet.sender_info)
        await handle_report(packet)

    async def watched(packet: RtpPacket, arrival_time_ms: int) -> None:
        if reports:
            ticks = (packet.timestamp - reports[-1].rtp_timestamp + 2**31) % 2**32 - 2**31
            told.append(reports[-1].ntp_timestamp / 2**32 - 2_208_988_800 + ticks / 90_000)
            ages.append(time.time() - told[-1])
        await handle(packet, arrival_time_ms)

    receiver._handle_rtcp_packet = report_watched  # type: ignore[method-assign]
    receiver._handle_rtp_packet = watched  # type: ignore[method-assign]
    await engine.news.until(lambda: len(told) > 5)
    assert min(ages) > 0.1
    # One may be wrong by as long as the process stood still between two looks at clocks.
    assert median(min(abs(at - real) for real in engine.source.captured) for at in told) < 0.005


async def test_viewers_share_one_encoder_and_each_decodes() -> None:
    async with loopback.engine() as first, loopback.engine() as second, loopback.engine() as third:
        second.video = third.video = first.video
        viewers = [Viewer(engine) for engine in (first, second, third)]
        for engine in (first, second, third):
            engine.connect("v", "video")
        for viewer in viewers:
            await viewer.plays("0", 10)
        assert first.video.running_encoders == 1
        assert first.video.made[0].figures().viewers == 3
        assert len(first.video.made) == 1
        for viewer in viewers:
            await viewer.close()
        for engine in (first, second, third):
            await engine.close()


async def test_stalled_source_and_its_recovery_are_notified(engine: Engine, viewer: Viewer) -> None:
    engine.connect("v", "video")
    await engine.until("v", StreamStatus.RUNNING)
    engine.source.running.clear()
    await engine.until("v", StreamStatus.NOT_RUNNING)
    engine.source.running.set()
    await viewer.plays()
    await engine.until("v", StreamStatus.RUNNING)


@pytest.mark.parametrize("kind", ["video", "audio"])
async def test_a_viewer_that_has_nothing_to_report_is_not_taken_for_gone(kind: str) -> None:
    async with loopback.engine(speed=8.0) as engine, loopback.viewer(engine) as viewer:
        engine.connect("s", kind)
        engine.session.suspend("s")
        await engine.until("s", StreamStatus.SUSPENDED)
        begin = asyncio.get_running_loop().time()
        await engine.news.until(lambda: viewer.states[-1:] == ["connected"])
        with pytest.raises(TimeoutError):
            await engine.news.until(lambda: engine.byes, 1.2)
        assert asyncio.get_running_loop().time() - begin > 1.0
        engine.session.resume("s")
        await viewer.plays("0")


async def test_a_viewer_that_vanishes_is_noticed() -> None:
    async with loopback.engine(speed=8.0) as engine, loopback.viewer(engine) as viewer:
        engine.connect("v", "video")
        await viewer.plays()
        (connection,) = viewer.connections.values()
        for protocol in connection.getTransceivers()[0].sender.transport.transport._connection._protocols:
            protocol.transport.abort()
        await engine.news.until(lambda: engine.byes)
        assert [bye.reason for bye in engine.byes] == ["the viewer is gone"]
        await engine.until("v", StreamStatus.NOT_CONNECTED)


async def test_a_viewer_that_asks_for_a_key_frame_gets_one(engine: Engine, viewer: Viewer) -> None:
    engine.connect("v", "video")
    await viewer.plays()
    figures = engine.video.renditions("video/H264")[0].figures
    before = figures().repairs
    (connection,) = viewer.connections.values()
    receiver = connection.getTransceivers()[0].receiver
    # Where packets were lost, what is sent again follows as a stream of its own.
    ssrc, *_ = receiver._RTCRtpReceiver__remote_streams  # type: ignore[attr-defined]
    await receiver._send_rtcp_pli(ssrc)
    await viewer.plays("0", 15)
    assert figures().repairs == before + 1
    assert (await engine.session.stats("v")).key_frame_requests == 1


async def test_garbage_ends_one_peer_and_nothing_else(engine: Engine, viewer: Viewer) -> None:
    engine.connect("v", "video")
    await viewer.plays()
    viewer.bend_answer = lambda sdp: sdp[: len(sdp) // 2]
    engine.connect("a", "audio")
    await engine.news.until(lambda: viewer.refusals)
    assert len(engine.byes) == 1
    assert engine.session.stream_ids == ()
    viewer.bend_answer = str
    engine.connect("w", "video")
    await viewer.plays()


async def test_sixteen_sections_and_no_more(engine: Engine, viewer: Viewer) -> None:
    for number in range(16):
        engine.connect(f"s{number}", "audio")
    with pytest.raises(TooManySections):
        engine.connect("one too many", "audio")
    await viewer.plays("15")
    assert len(engine.offers) == 1
    engine.session.disconnect("s3")
    await engine.news.until(lambda: len(engine.offers) == 2)
    await viewer.plays("15")
    engine.connect("in its place", "audio")
    await viewer.plays("3")
