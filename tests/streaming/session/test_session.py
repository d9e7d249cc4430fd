"""The media session of an application: its streams, their status, figures and end."""

import logging

import pytest
from openrois_signaling.messages import IceServer
from openrois_signaling.negotiation import ANSWER_TIMEOUT
from openrois_streaming.adaptation.rung import ladder
from openrois_streaming.adaptation.viewer import Caps
from openrois_streaming.errors import NoCommonCodec, TooManySections, UnknownPeer, UnknownStream
from openrois_streaming.liveness import STALL
from openrois_streaming.publish.key_frames import KeyFrameCause
from openrois_streaming.rtp.reports import ReceiverReport
from openrois_streaming.session.session import IDLE, StreamSession
from openrois_streaming.state import StreamStatus

from tests.support.streaming import settle
from tests.support.theatre import Theatre
from tests.support.viewing import Application, frame


async def test_stream_is_running_when_its_frames_reach_the_viewer(theatre: Theatre) -> None:
    theatre.connect()
    assert theatre.session.status("v") is StreamStatus.NOT_CONNECTED
    connection = await theatre.up()
    assert theatre.told == [("v", "not_running")]
    await theatre.play(connection)
    assert theatre.told == [("v", "not_running"), ("v", "running")]
    assert theatre.changes[-1].at == pytest.approx(theatre.clock.wall(), abs=1.0)
    assert theatre.session.status("v") is StreamStatus.RUNNING


async def test_single_pictures_do_not_change_the_status(theatre: Theatre) -> None:
    theatre.publisher.rung = ladder(320, 180, 30)[0]
    theatre.session.connect("v", "engine/Video", theatre.publisher, "video", caps=Caps(max_bitrate=40_000))
    connection = await theatre.up()
    for number in range(100):
        answered = number == 0 or theatre.video.asked[-1] is KeyFrameCause.STILL
        theatre.video.asked.append(KeyFrameCause.START)
        await theatre.video.source.feed(frame(number, keyframe=answered, at=number / 8))
        if number % 10 == 5:
            connection.report((await theatre.session.stats("v")).frames_sent)
        await theatre.clock.advance(1 / 8)
    assert theatre.told == [("v", "not_running"), ("v", "running")]
    assert (await theatre.session.stats("v")).frames_sent == 8, "nothing else got through"


async def test_suspending_and_resuming_needs_no_negotiation(theatre: Theatre) -> None:
    theatre.connect()
    connection = await theatre.up()
    await theatre.play(connection)
    theatre.session.suspend("v")
    theatre.session.suspend("v")
    assert theatre.told[-1] == ("v", "running")
    await settle()
    assert theatre.told[-1] == ("v", "suspended")
    assert theatre.video.readers == 0
    await theatre.wait(30.0)
    assert theatre.told[-1] == ("v", "suspended")
    theatre.session.resume("v")
    await settle()
    assert theatre.told[-1] == ("v", "suspended")
    await theatre.play(connection)
    assert theatre.told[-1] == ("v", "running")
    assert theatre.changes[-1].resumed
    assert theatre.video.asked == [KeyFrameCause.START] * 2
    assert len(theatre.offers) == 1


async def test_stalled_source_and_its_recovery_change_the_status(theatre: Theatre) -> None:
    theatre.connect()
    connection = await theatre.up()
    await theatre.play(connection)
    await theatre.wait(STALL - 0.2)
    assert theatre.told[-1] == ("v", "running")
    await theatre.wait(0.3)
    assert theatre.told[-1] == ("v", "not_running")
    await theatre.play(connection)
    assert theatre.told[-1] == ("v", "running")


async def test_a_resumed_stream_whose_source_is_dead_is_not_running(theatre: Theatre) -> None:
    theatre.connect()
    connection = await theatre.up()
    await theatre.play(connection)
    theatre.session.suspend("v")
    await theatre.wait(1.0)
    theatre.session.resume("v")
    await theatre.wait(STALL + 0.2)
    assert theatre.told[-1] == ("v", "not_running")


async def test_a_disconnected_stream_ends_and_another_takes_its_section(theatre: Theatre) -> None:
    theatre.connect("a")
    connection = await theatre.up()
    await theatre.play(connection)
    theatre.session.disconnect("a")
    assert theatre.session.stream_ids == ()
    offer = await theatre.offered()
    assert theatre.changes[-1].ended
    assert offer.streams == ()
    await theatre.answer()
    theatre.connect("b")
    await theatre.answer()
    assert [(each.mid, each.stream_id) for each in theatre.offers[-1].streams] == [("0", "b")]
    await theatre.play(connection)
    assert theatre.told[-1] == ("b", "running")
    for call in (theatre.session.suspend, theatre.session.resume, theatre.session.disconnect, theatre.session.status):
        with pytest.raises(UnknownStream):
            call("a")
    with pytest.raises(UnknownStream):
        await theatre.session.stats("a")


async def test_an_unanswered_offer_gives_the_stream_back(theatre: Theatre) -> None:
    theatre.connect()
    await theatre.wait(ANSWER_TIMEOUT + 0.2)
    assert [bye.reason for bye in theatre.byes] == ["the offer was not answered in time"]
    assert [(change.stream_id, change.status, change.ended) for change in theatre.changes] == [
        ("v", StreamStatus.NOT_CONNECTED, True)
    ]
    theatre.connect("w")
    await settle()
    assert theatre.offers[-1].peer_id == "engine/p2"
    assert theatre.offers[-1].replaces is None


async def test_refused_connect_changes_nothing(theatre: Theatre) -> None:
    with pytest.raises(NoCommonCodec):
        theatre.session.connect("v", "engine/Video", theatre.publisher, "video", ["AV1"])
    theatre.connect()
    with pytest.raises(ValueError, match="once"):
        theatre.connect()
    await settle()
    theatre.connections[0].room = 1
    with pytest.raises(TooManySections):
        theatre.connect("w")
    assert theatre.session.stream_ids == ("v",)
    await theatre.session.close("enough")
    with pytest.raises(ValueError, match="open session"):
        theatre.connect("x")


async def test_messages_to_unknown_peers_are_refused(theatre: Theatre) -> None:
    theatre.connect()
    offer = await theatre.offered()
    with pytest.raises(UnknownPeer):
        await theatre.answer(offer=offer.model_copy(update={"peer_id": "engine/other"}))
    with pytest.raises(UnknownPeer):
        await theatre.trickle("candidate", peer_id="engine/other")
    with pytest.raises(UnknownPeer):
        theatre.session.restart("engine/other")
    await theatre.trickle("candidate")


async def test_a_viewer_that_vanishes_ends_its_streams(theatre: Theatre) -> None:
    theatre.connect()
    connection = await theatre.up()
    await theatre.play(connection)
    connection.answers_questions = False
    await theatre.wait(4.2)
    assert [bye.reason for bye in theatre.byes] == ["the viewer is gone"]
    assert theatre.changes[-1].ended
    assert connection.closed


async def test_a_process_that_slept_does_not_blame_its_viewers(theatre: Theatre) -> None:
    theatre.connect()
    connection = await theatre.up()
    await theatre.play(connection)
    theatre.clock.jump(60.0)
    await settle()
    await theatre.play(connection)
    assert theatre.byes == []
    assert theatre.told[-1] == ("v", "running")


async def test_a_close_says_bye_and_ends_all_streams(theatre: Theatre) -> None:
    theatre.connect("v")
    await theatre.up()
    theatre.connect("w")
    theatre.session.restart("engine/p1")
    await settle()
    await theatre.session.close("the lease has ended")
    assert {(bye.peer_id, bye.reason) for bye in theatre.byes} == {
        ("engine/p1", "the lease has ended"),
        ("engine/p2", "the lease has ended"),
    }
    assert sorted(change.stream_id for change in theatre.changes if change.ended) == ["v", "w"]
    await theatre.session.close("again")
    assert len(theatre.byes) == 2


async def test_new_peers_get_the_ice_servers_of_the_day(theatre: Theatre) -> None:
    theatre.session.ice_servers = (IceServer(urls=("stun:stun.example.org",)),)
    theatre.connect()
    assert theatre.connections[0].ice_servers == theatre.session.ice_servers


async def test_figures_of_a_stream(theatre: Theatre) -> None:
    theatre.connect()
    connection = await theatre.up()
    fresh = await theatre.session.stats("v")
    assert (fresh.frames_sent, fresh.round_trip_time, fresh.packets_lost, fresh.jitter) == (0, None, None, None)
    await theatre.play(connection, 1.0)
    stats = await theatre.session.stats("v")
    assert (stats.stream_id, stats.component_ref, stats.kind) == ("v", "engine/Video", "video")
    assert (stats.status, stats.codec) == (StreamStatus.RUNNING, "video/VP8")
    assert (stats.frames_sent, stats.key_frames, stats.bytes_sent) == (10, 1, 50)
    assert (stats.packets_lost, stats.fraction_lost, stats.jitter) == (0, 0.0, 0.001)


async def test_internal_error_ends_the_session_with_notification(
    theatre: Theatre, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    theatre.connect()
    await theatre.up()

    def judge(*_: object) -> None:
        raise RuntimeError("a mistake")

    monkeypatch.setattr("openrois_streaming.peer.stream.Stream.judge", judge)
    with caplog.at_level(logging.ERROR):
        await theatre.wait(0.2)
    assert [bye.reason for bye in theatre.byes] == ["an internal error of the engine"]
    assert theatre.changes[-1].ended
    assert "a mistake" in caplog.text


async def test_session_can_be_closed_from_its_notification() -> None:
    application = Application()
    session: StreamSession = application.session
    await session.close("never used")
    assert application.byes == []


async def test_an_offer_whose_answer_could_not_be_read_is_not_given_up(theatre: Theatre) -> None:
    theatre.connect()
    await theatre.offered()
    await theatre.wait(1)
    theatre.clock.jump(ANSWER_TIMEOUT * 2)
    await settle()
    assert not theatre.byes
    connection = await theatre.up()
    await theatre.play(connection)
    assert theatre.told[-1] == ("v", "running")


async def test_a_session_without_streams_ends_its_peer_connection_after_a_while(theatre: Theatre) -> None:
    theatre.connect("a")
    connection = await theatre.up()
    await theatre.play(connection)
    theatre.session.disconnect("a")
    await theatre.answer()
    await theatre.wait(IDLE - 1)
    assert not theatre.byes
    theatre.connect("b")
    await theatre.answer()
    await theatre.play(connection)
    theatre.session.disconnect("b")
    await theatre.answer()
    await theatre.wait(IDLE - 1)
    assert not theatre.session.is_over
    await theatre.wait(2)
    assert theatre.session.is_over
    assert [bye.reason for bye in theatre.byes] == ["no stream is left to play"]


async def test_the_round_trip_is_the_longest_that_its_viewer_reports_of_what_is_sent(theatre: Theatre) -> None:
    def report(number: int, *seconds: float) -> None:
        for section, each in zip(theatre.connections[number].sections, seconds, strict=True):
            assert section.stream_path is not None
            section.stream_path.reported(ReceiverReport(1, 0.0, 0, 90, round_trip_time=each))

    assert theatre.session.round_trip_time is None
    theatre.connect("v")
    theatre.connect("w")
    await theatre.up()
    assert theatre.session.round_trip_time is None
    report(0, 0.7, 0.3)
    assert theatre.session.round_trip_time == 0.7
    # Until the viewer reports on the peer connection that replaces it, that of the old one counts.
    theatre.session.restart("engine/p1")
    await settle()
    assert theatre.session.round_trip_time == 0.7
    await theatre.up(1)
    report(1, 0.6, 0.2)
    assert theatre.session.round_trip_time == 0.6
    theatre.session.suspend("v")
    assert theatre.session.round_trip_time == 0.2
