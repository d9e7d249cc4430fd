"""Offers, answers and candidates between an application and a game engine that does WebRTC itself."""

import pytest
from openrois_avatar.facades.streamer import Found, NotOffered, Offered
from openrois_signaling.messages import CANDIDATES_LIMIT, SDP_LIMIT, Answer, Candidate, Offer
from openrois_signaling.negotiation import ANSWER_TIMEOUT
from openrois_streaming.errors import (
    InvalidCandidate,
    InvalidDescription,
    StaleGeneration,
    TooManyCandidates,
    UnexpectedAnswer,
    UnknownPeer,
)

from tests.support.facade_session import AUDIO, BAD, BOTH, CHANNEL, LINE, VIDEO, SessionHarness, media, sdp, streams


def test_an_offer_that_is_not_answered_ends_its_streams() -> None:
    harness = SessionHarness()
    harness.connect("video")
    harness.offers()
    harness.pass_time(ANSWER_TIMEOUT)
    assert harness.told() == ["video NOT_CONNECTED"]
    assert harness.byes() == [("avatar/p1", "the offer was not answered in time")]
    assert harness.engine.dismissed == harness.engine.players


def test_time_without_an_answer_is_known() -> None:
    harness = SessionHarness()
    harness.connect("video")
    offer = harness.offers()
    harness.pass_time(3.0)
    assert harness.session.unanswered_for() == pytest.approx(3.125)
    harness.answers(offer)
    harness.pass_time()
    assert harness.session.unanswered_for() is None


def test_unwanted_stream_is_not_waited_for() -> None:
    harness = SessionHarness()
    harness.connect("video")
    harness.offers()
    harness.session.disconnect("video")
    harness.pass_time()
    assert harness.byes() == [("avatar/p1", "no stream is left to play")]
    assert harness.session.is_over


def test_stream_that_is_not_offered_ends_and_is_refused_afterwards() -> None:
    harness = SessionHarness()
    harness.connect("video", "audio")
    offer = harness.offers(sdp(VIDEO))
    assert streams(offer) == {"video": "0"}
    harness.answers(offer)
    harness.pass_time()
    assert harness.told() == ["audio NOT_CONNECTED", "video RUNNING"]
    with pytest.raises(NotOffered, match="sends no audio"):
        harness.connect("audio")
    harness.session.close("the game engine is gone")
    harness.connect("audio")


@pytest.mark.parametrize(
    ("text", "why"),
    [
        (sdp(AUDIO), "the game engine offers none of the connected streams"),
        (
            sdp(VIDEO, CHANNEL),
            "the game engine offers a data channel, which is not supported; offer audio and video only",
        ),
        ("hello", "the description is not SDP"),
        (
            BOTH + "a=x:" + "é" * (SDP_LIMIT // 2) + "\r\n",
            f"the description has more than {SDP_LIMIT} bytes, which is the limit",
        ),
    ],
)
def test_an_offer_that_cannot_be_passed_on_ends_its_player(text: str, why: str) -> None:
    harness = SessionHarness()
    harness.connect("video")
    harness.hears(lambda player: Offered(player, text))
    harness.pass_time()
    assert harness.byes() == [("avatar/p1", why)]
    assert harness.told() == ["video NOT_CONNECTED"]
    assert harness.engine.dismissed == harness.engine.players


def test_an_answer_that_takes_more_than_was_connected_ends_its_player() -> None:
    harness = SessionHarness()
    harness.connect("video")
    offer = harness.offers()
    wrong = sdp(media("video", "0", "recvonly"), media("audio", "1", "recvonly"))
    with pytest.raises(InvalidDescription, match="section 1 was not connected"):
        harness.session.apply_answer(Answer(peer_id=offer.peer_id, generation=1, sdp=wrong))
    assert harness.engine.answers == []
    assert harness.byes() == [(offer.peer_id, "section 1 was not connected: it must be answered inactive")]


def test_a_game_engine_may_offer_anew_and_waits_for_the_answer_before() -> None:
    harness = SessionHarness()
    harness.connect("video")
    first = harness.offers()
    harness.hears(lambda player: Offered(player, sdp(VIDEO)))
    assert harness.sent == [first]
    harness.answers(first)
    second = harness.sent[-1]
    assert isinstance(second, Offer)
    assert (second.sdp, second.generation, second.peer_id) == (sdp(VIDEO), 2, first.peer_id)
    with pytest.raises(UnexpectedAnswer):
        harness.answers(first)
    harness.answers(second)
    third = harness.offers(BOTH)
    assert third.generation == 3
    assert streams(third) == {"video": "0"}


def test_a_later_offer_that_cannot_be_passed_on_ends_the_player_with_the_answer() -> None:
    harness = SessionHarness()
    harness.connect("video")
    first = harness.offers()
    harness.hears(lambda player: Offered(player, sdp(AUDIO)))
    with pytest.raises(InvalidDescription, match="none of the connected streams"):
        harness.answers(first)
    assert harness.session.is_over is False
    harness.pass_time()
    assert harness.session.is_over


def test_candidates_of_the_game_engine_follow_its_offer() -> None:
    harness = SessionHarness()
    harness.connect("video")
    for found in (LINE, "x" * 2000):
        harness.hears(lambda player, found=found: Found(player, found, "0", 0))  # type: ignore[misc]
    assert harness.sent == []
    harness.offers()
    harness.hears(lambda player: Found(player, "", None, None))
    harness.hears(lambda player: Found(player, LINE, None, None))
    got = [each for each in harness.sent[1:] if isinstance(each, Candidate)]
    assert [(each.candidate, each.sdp_mid, each.generation) for each in got] == [(LINE, "0", 1), (None, None, 1)]
    for _ in range(CANDIDATES_LIMIT):
        harness.hears(lambda player: Found(player, LINE, "0", 0))
    assert len([each for each in harness.sent if isinstance(each, Candidate)]) < CANDIDATES_LIMIT


def test_candidates_of_the_application_are_checked_one_by_one_and_wait_for_its_answer() -> None:
    harness = SessionHarness()
    harness.connect("video")
    offer = harness.offers()

    def finds(candidate: str | None, generation: int = 1) -> None:
        mid = None if candidate is None else "0"
        harness.session.add_candidate(
            Candidate(peer_id=offer.peer_id, generation=generation, candidate=candidate, sdp_mid=mid)
        )

    finds(LINE)
    finds(BAD)
    harness.answers(offer, more=f"a={LINE} in answer\r\na={BAD}\r\na=candidate:10.0.0.1\r\n")
    assert [each.candidate for each in harness.engine.found] == [f"{LINE} in answer", f"{LINE} in answer", LINE]
    assert LINE not in harness.engine.answers[0][1]
    assert {(each.sdp_mid, each.sdp_m_line_index) for each in harness.engine.found} == {("0", 0), ("1", 1)}
    finds(LINE)
    finds("candidate:elsewhere")
    finds(None)
    assert len(harness.engine.found) == 4
    with pytest.raises(InvalidCandidate):
        finds(BAD)
    with pytest.raises(StaleGeneration):
        finds(LINE, 2)
    for _ in range(CANDIDATES_LIMIT - 6):
        finds(None)
    with pytest.raises(TooManyCandidates):
        finds(LINE)
    with pytest.raises(UnknownPeer):
        harness.session.add_candidate(Candidate(peer_id="avatar/p9", generation=1, candidate=None))


@pytest.mark.parametrize(
    ("mid", "index", "passed_on"),
    [("1", None, ("1", 1)), (None, 1, ("1", 1)), ("1", 1, ("1", 1)), ("x", None, ("x", None)), (None, 7, (None, 7))],
)
def test_a_candidate_names_its_section_both_ways(
    mid: str | None, index: int | None, passed_on: tuple[str | None, int | None]
) -> None:
    harness = SessionHarness()
    offer = harness.plays("video", "audio")
    found = Candidate(peer_id=offer.peer_id, generation=1, candidate=LINE, sdp_mid=mid, sdp_m_line_index=index)
    harness.session.add_candidate(found)
    assert [(each.sdp_mid, each.sdp_m_line_index) for each in harness.engine.found] == [passed_on]
