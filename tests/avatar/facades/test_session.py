"""What an application sees of a game engine that does WebRTC itself: players come and go as its streams do."""

import pytest
from openrois_avatar.facades.session import HANDOVER
from openrois_avatar.facades.streamer import Left, NoRoom
from openrois_signaling.messages import IceServer
from openrois_signaling.negotiation import PREPARE_TIMEOUT
from openrois_streaming.errors import TooManySections, UnknownPeer, UnknownStream

from tests.support.facade_session import BOTH, SessionHarness, streams


def test_streams_connected_within_a_moment_are_offered_together_and_run_when_answered() -> None:
    harness = SessionHarness()
    harness.session.ice_servers = (IceServer(urls=("stun:stun.example.org",)),)
    harness.connect("video", "audio")
    assert harness.engine.servers == [harness.session.ice_servers]
    assert harness.session.status("video").value == "STREAMING_NOT_CONNECTED"
    offer = harness.offers()
    assert (offer.sdp, offer.generation, offer.replaces) == (BOTH, 1, None)
    assert streams(offer) == {"video": "0", "audio": "1"}
    assert {each.direction for each in offer.streams} == {"recvonly"}
    assert harness.told() == []
    harness.answers(offer)
    assert harness.engine.answers[0][0] == harness.engine.players[0]
    harness.pass_time()
    assert harness.told() == ["video RUNNING", "audio RUNNING"]
    assert not harness.session.is_over


def test_another_stream_comes_with_another_player_that_replaces_the_first() -> None:
    harness = SessionHarness()
    first = harness.plays("video")
    harness.connect("audio")
    second = harness.offers()
    assert second.replaces == first.peer_id
    assert streams(second) == {"video": "0", "audio": "1"}
    assert harness.engine.dismissed == []
    harness.answers(second)
    harness.pass_time()
    assert harness.told() == ["video RUNNING", "audio RUNNING"]
    harness.pass_time(HANDOVER)
    assert harness.engine.dismissed == harness.engine.players[:1]
    assert harness.byes() == [(first.peer_id, "it was replaced")]
    assert harness.told() == []


def test_a_disconnected_stream_leaves_with_its_player_and_the_last_one_ends_all() -> None:
    harness = SessionHarness()
    first = harness.plays("video", "audio")
    harness.session.disconnect("audio")
    harness.pass_time()
    second = harness.offers()
    assert streams(second) == {"video": "0"}
    harness.answers(second)
    harness.session.disconnect("video")
    harness.pass_time()
    assert harness.byes() == [
        (second.peer_id, "no stream is left to play"),
        (first.peer_id, "no stream is left to play"),
    ]
    assert harness.told() == ["video RUNNING", "audio RUNNING", "audio NOT_CONNECTED", "video NOT_CONNECTED"]
    assert harness.session.is_over
    with pytest.raises(UnknownStream):
        harness.session.status("video")


def test_a_suspended_stream_has_no_player_and_comes_back_with_another() -> None:
    harness = SessionHarness()
    first = harness.plays("video")
    harness.told()
    for _ in range(2):
        harness.session.suspend("video")
        harness.pass_time()
    assert harness.engine.dismissed == harness.engine.players
    assert harness.byes() == []
    assert harness.told() == ["video SUSPENDED"]
    harness.session.restart(first.peer_id)
    harness.pass_time()
    assert len(harness.engine.players) == 1
    assert not harness.session.is_over
    harness.session.resume("video")
    harness.pass_time()
    second = harness.offers()
    assert second.replaces == first.peer_id
    assert harness.told() == []
    harness.answers(second)
    harness.pass_time()
    assert harness.told() == ["video RESUMED", "video RUNNING"]


def test_suspended_stream_ends_the_replaced_player_at_once() -> None:
    harness = SessionHarness()
    harness.plays("video", "audio")
    harness.told()
    harness.session.suspend("video")
    harness.pass_time()
    second = harness.offers()
    assert streams(second) == {"audio": "1"}
    assert harness.engine.dismissed == []
    harness.answers(second)
    harness.pass_time()
    assert harness.engine.dismissed == harness.engine.players[:1]
    # A bye would say that the picture is over.
    assert harness.byes() == []
    assert harness.told() == ["video SUSPENDED"]


def test_all_suspended_while_one_player_replaces_another() -> None:
    harness = SessionHarness()
    first = harness.plays("video")
    harness.connect("audio")
    harness.answers(harness.offers())
    for kind in ("video", "audio"):
        harness.session.suspend(kind)
    harness.pass_time()
    assert sorted(harness.engine.dismissed) == sorted(harness.engine.players)
    harness.session.end_peer("avatar/p2", "the page is closed")
    assert harness.byes() == [("avatar/p2", "the page is closed")]
    with pytest.raises(UnknownPeer):
        harness.session.end_peer(first.peer_id, "and again")


def test_a_restart_brings_a_new_player_once() -> None:
    harness = SessionHarness()
    first = harness.plays("video")
    harness.session.restart(first.peer_id)
    harness.pass_time()
    harness.session.restart(first.peer_id)
    harness.session.restart("avatar/p2")
    harness.pass_time()
    assert len(harness.engine.players) == 2
    second = harness.offers()
    assert second.replaces == first.peer_id
    # What is wanted meanwhile waits until this one is answered, and then takes the place of both.
    harness.connect("audio")
    assert len(harness.engine.players) == 2
    harness.answers(second)
    harness.pass_time()
    assert len(harness.engine.players) == 3
    assert harness.byes() == [(first.peer_id, "it was replaced")]
    with pytest.raises(UnknownPeer):
        harness.session.restart("avatar/p9")


def test_a_player_that_cannot_be_had_in_time_leaves_the_one_before() -> None:
    harness = SessionHarness()
    first = harness.plays("video")
    harness.connect("audio")
    harness.told()
    harness.pass_time(PREPARE_TIMEOUT)
    assert harness.byes() == [("avatar/p2", "no description could be made in time")]
    assert harness.told() == ["audio NOT_CONNECTED"]
    assert harness.session.status("video").value == "STREAMING_RUNNING"
    harness.session.end_peer(first.peer_id, "the page is closed")
    harness.pass_time()
    assert harness.told() == ["video NOT_CONNECTED"]
    assert harness.session.is_over


def test_a_game_engine_that_ends_a_player_ends_its_streams_and_no_others() -> None:
    harness = SessionHarness()
    harness.plays("video")
    harness.told()
    harness.session.handle_engine_message(Left("another id", "?"))
    harness.connect("audio")
    harness.hears(lambda player: Left(player, "overloaded"))
    harness.pass_time()
    assert harness.byes() == [("avatar/p2", "overloaded")]
    assert harness.told() == ["audio NOT_CONNECTED"]


def test_second_stream_of_a_kind_is_refused_and_any_without_room() -> None:
    harness = SessionHarness()
    harness.plays("video")
    with pytest.raises(TooManySections, match="a video stream is connected already"):
        harness.connect("video")
    harness.engine.has_room = False
    harness.connect("audio")
    harness.session.close("the application is gone")
    with pytest.raises(NoRoom):
        harness.connect("video")
    harness.there = None
    with pytest.raises(NoRoom):
        harness.connect("video")


def test_a_game_engine_without_room_for_two_gets_the_second_player_when_the_first_is_gone() -> None:
    harness = SessionHarness()
    first = harness.plays("video")
    harness.engine.has_room = False
    harness.connect("audio")
    assert harness.engine.dismissed == harness.engine.players
    harness.pass_time()
    harness.engine.has_room = True
    harness.pass_time()
    second = harness.offers()
    assert second.replaces == first.peer_id
    assert harness.byes() == []


def test_a_place_that_does_not_come_is_not_awaited_for_ever() -> None:
    harness = SessionHarness()
    first = harness.plays("video")
    harness.told()
    harness.engine.has_room = False
    harness.session.restart(first.peer_id)
    harness.pass_time()
    harness.pass_time(PREPARE_TIMEOUT)
    assert harness.byes() == [(first.peer_id, "the game engine takes no further viewer")]
    assert harness.told() == ["video NOT_CONNECTED"]


def test_a_game_engine_that_is_gone_when_a_player_is_wanted() -> None:
    harness = SessionHarness()
    harness.plays("video")
    harness.session.suspend("video")
    harness.pass_time()
    harness.there = None
    harness.session.resume("video")
    harness.pass_time()
    assert harness.told()[-1] == "video NOT_CONNECTED"
    assert harness.byes()[-1] == ("avatar/p1", "the game engine is gone")


def test_a_resumed_stream_that_was_not_yet_let_go_goes_on() -> None:
    harness = SessionHarness()
    harness.plays("video")
    harness.session.suspend("video")
    harness.session.resume("video")
    harness.pass_time()
    assert len(harness.engine.players) == 1
    assert harness.session.status("video").value == "STREAMING_RUNNING"


def test_an_application_that_is_done_with_the_player_before_says_so() -> None:
    harness = SessionHarness()
    first = harness.plays("video")
    harness.connect("audio")
    harness.session.end_peer(first.peer_id, "replaced")
    harness.answers(harness.offers())
    harness.pass_time()
    assert harness.byes() == [(first.peer_id, "replaced")]
    assert harness.told() == ["video RUNNING", "audio RUNNING"]
