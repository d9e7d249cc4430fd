"""A peer connection that replaces another: on request, and with the next codec where one cannot be encoded."""

import pytest
from openrois_signaling.negotiation import ANSWER_TIMEOUT
from openrois_streaming.errors import UnknownPeer
from openrois_streaming.peer.peers import REPLACE_TIMEOUT
from openrois_streaming.session.session import CODECS_APART
from openrois_streaming.state import StreamStatus

from tests.support.streaming import settle
from tests.support.theatre import Theatre


async def test_a_replacement_plays_before_the_old_one_goes(theatre: Theatre) -> None:
    theatre.connect("v")
    theatre.connect("w")
    old = await theatre.up()
    await theatre.play(old)
    theatre.session.suspend("w")
    await settle()
    assert theatre.session.restart("engine/p1") == "engine/p2"
    assert theatre.session.restart("engine/p1") == "engine/p2"
    offer = await theatre.offered()
    assert (offer.peer_id, offer.replaces, offer.generation) == ("engine/p2", "engine/p1", 1)
    assert [each.stream_id for each in offer.streams] == ["v", "w"]
    assert list(theatre.session.peer_ids) == ["engine/p2", "engine/p1"]
    new = await theatre.up(1)
    closed = [old.closed]
    await theatre.play(new)
    assert [(bye.peer_id, bye.reason) for bye in theatre.byes] == [("engine/p1", "it was replaced")]
    await settle()
    closed.append(old.closed)
    assert closed == [False, True]
    assert list(theatre.session.peer_ids) == ["engine/p2"]
    assert ("v", "not_connected") not in theatre.told
    assert theatre.session.status("v") is StreamStatus.RUNNING
    assert theatre.session.status("w") is StreamStatus.SUSPENDED
    stats = await theatre.session.stats("v")
    assert stats.frames_sent >= 10


async def test_a_replacement_that_does_not_play_replaces_after_a_while(theatre: Theatre) -> None:
    theatre.connect()
    await theatre.up()
    theatre.session.restart("engine/p1")
    await theatre.up(1)
    await theatre.wait(REPLACE_TIMEOUT - 0.2)
    assert theatre.byes == []
    await theatre.wait(0.4)
    assert [bye.peer_id for bye in theatre.byes] == ["engine/p1"]


async def test_a_replacement_that_fails_leaves_the_old_one_in_its_place(theatre: Theatre) -> None:
    theatre.connect("v")
    old = await theatre.up()
    theatre.session.restart("engine/p1")
    await settle()
    theatre.connect("w")
    theatre.session.disconnect("v")
    offer = await theatre.offered()
    assert (offer.peer_id, offer.streams) == ("engine/p1", ())
    await theatre.answer()
    await theatre.wait(ANSWER_TIMEOUT + 0.2)
    assert [bye.peer_id for bye in theatre.byes] == ["engine/p2"]
    assert theatre.session.peer_ids == ("engine/p1",)
    offer = await theatre.offered()
    assert offer.peer_id == "engine/p1"
    assert [listed.stream_id for listed in offer.streams] == ["w"]
    await theatre.answer()
    assert theatre.session.stream_ids == ("w",)
    assert not old.closed


async def test_a_stream_for_which_the_old_one_has_no_room_ends(theatre: Theatre) -> None:
    theatre.connect("v")
    await theatre.up()
    theatre.connections[0].room = 1
    theatre.session.restart("engine/p1")
    await settle()
    theatre.connect("w")
    await theatre.wait(ANSWER_TIMEOUT + 0.2)
    assert theatre.session.stream_ids == ("v",)
    assert [change.stream_id for change in theatre.changes if change.ended] == ["w"]


async def test_there_are_never_more_than_two_peers(theatre: Theatre) -> None:
    theatre.connect()
    await theatre.up()
    theatre.session.restart("engine/p1")
    theatre.session.restart("engine/p2")
    assert theatre.session.peer_ids == ("engine/p3", "engine/p2")
    assert [bye.peer_id for bye in theatre.byes] == ["engine/p1"]
    await settle()
    assert theatre.connections[0].closed


async def test_stream_falling_back_to_a_closed_peer_ends(theatre: Theatre) -> None:
    theatre.connect()
    await theatre.up()
    theatre.session.restart("engine/p1")
    theatre.connect("w")
    theatre.connect("x")
    await settle()
    theatre.connections[0].closed_there = True
    theatre.connections[1].become("closed")
    await settle()
    assert [bye.reason for bye in theatre.byes] == ["the application closed the peer connection", "closed there"]
    assert {change.stream_id for change in theatre.changes if change.ended} == {"v", "w", "x"}
    assert theatre.session.is_over


async def test_a_stream_gets_another_peer_in_place_of_one_that_is_closed_there(theatre: Theatre) -> None:
    theatre.connect()
    await theatre.up()
    theatre.connections[0].closed_there = True
    theatre.connect("w")
    await settle()
    assert [bye.reason for bye in theatre.byes] == ["closed there"]
    assert theatre.session.stream_ids == ("w",)
    assert [each.stream_id for each in theatre.offers[-1].streams] == ["w"]
    assert theatre.offers[-1].peer_id == "engine/p2"


async def test_a_peer_without_streams_is_not_replaced(theatre: Theatre) -> None:
    theatre.connect()
    await theatre.up()
    theatre.session.disconnect("v")
    with pytest.raises(UnknownPeer):
        theatre.session.restart("engine/p1")
    assert [bye.reason for bye in theatre.byes] == ["there is no stream to carry"]


def offered(theatre: Theatre) -> tuple[str, ...]:
    """Return the media types in which the newest peer connection offers its first section."""
    path = theatre.connections[-1].sections[0].stream_path
    assert path is not None
    return path.stream.codecs


async def test_where_a_codec_cannot_be_encoded_the_next_is_offered_in_a_new_peer_connection(theatre: Theatre) -> None:
    theatre.session.connect("v", "engine/Video", theatre.publisher, "video", ["VP8", "H264"])
    await theatre.up()
    assert offered(theatre) == ("video/H264",)
    theatre.publisher.broken.add("video/H264")
    await theatre.wait(1.0)
    assert [offer.replaces for offer in theatre.offers] == [None, "engine/p1"]
    assert offered(theatre) == ("video/VP8",)
    await theatre.play(await theatre.up(1))
    assert theatre.session.status("v") is StreamStatus.RUNNING
    assert [(bye.peer_id, bye.reason) for bye in theatre.byes] == [("engine/p1", "it was replaced")]
    # Where that fails, too, nothing goes back and forth.
    theatre.publisher.broken.add("video/VP8")
    await theatre.wait(60.0)
    theatre.publisher.broken.remove("video/H264")
    await theatre.wait(60.0)
    assert len(theatre.offers) == 2


async def test_a_peer_connection_with_another_codec_that_does_not_come_about_is_tried_again(theatre: Theatre) -> None:
    theatre.session.connect("v", "engine/Video", theatre.publisher, "video", ["VP8", "H264"])
    await theatre.up()
    theatre.publisher.broken.add("video/H264")
    await theatre.wait(1.0)
    theatre.session.end_peer("engine/p2", "no path was found")
    await theatre.wait(CODECS_APART - 2.0)
    assert len(theatre.offers) == 2
    await theatre.wait(3.0)
    assert [offer.replaces for offer in theatre.offers] == [None, "engine/p1", "engine/p1"]
    assert offered(theatre) == ("video/VP8",)


async def test_a_codec_that_cannot_be_encoded_is_not_offered_to_the_next_viewer(theatre: Theatre) -> None:
    theatre.publisher.broken.add("video/H264")
    theatre.session.connect("v", "engine/Video", theatre.publisher, "video", ["H264", "VP8"])
    await theatre.up()
    assert offered(theatre) == ("video/VP8",)


@pytest.mark.parametrize("codecs", [["H264"], None])
async def test_a_viewer_that_knows_no_other_codec_or_chose_itself_is_left_alone(
    theatre: Theatre, codecs: list[str] | None
) -> None:
    theatre.session.connect("v", "engine/Video", theatre.publisher, "video", codecs)
    await theatre.up()
    theatre.publisher.broken.add("video/H264")
    await theatre.wait(5.0)
    assert len(theatre.offers) == 1
