"""Offers, answers and candidates of one peer connection, and their deadlines."""

import asyncio
import logging

import pytest
from openrois_signaling.messages import SDP_LIMIT, Bye, Candidate, Offer
from openrois_signaling.negotiation import ANSWER_TIMEOUT, APPLY_TIMEOUT, PREPARE_TIMEOUT
from openrois_streaming.errors import (
    InvalidCandidate,
    InvalidDescription,
    NoPath,
    PeerClosed,
    StaleGeneration,
    TooManyCandidates,
    TooManySections,
    UnexpectedAnswer,
    UnknownPeer,
)
from openrois_streaming.peer.peer import CONNECT_TIMEOUT
from openrois_streaming.peer.stream import Stream
from openrois_streaming.stats import Counters

from tests.support.peer_owner import Owner
from tests.support.streaming import settle


async def test_streams_that_come_together_are_offered_together(owner: Owner) -> None:
    owner.attach("a")
    owner.attach("b")
    await settle()
    offer = owner.said[0]
    assert isinstance(offer, Offer)
    assert len(owner.said) == 1
    assert (offer.generation, offer.replaces) == (1, "engine/o")
    assert [(each.mid, each.stream_id, each.direction) for each in offer.streams] == [
        ("0", "a", "recvonly"),
        ("1", "b", "recvonly"),
    ]


async def test_changes_during_an_offer_go_into_the_next(owner: Owner) -> None:
    first = owner.attach("a")
    await settle()
    owner.attach("b")
    owner.peer.detach(first)
    await settle()
    assert len(owner.said) == 1
    await owner.answer()
    await settle()
    offer = owner.said[1]
    assert isinstance(offer, Offer)
    assert (offer.generation, [each.stream_id for each in offer.streams]) == (2, ["b"])


async def test_an_idle_section_is_taken_over_by_a_stream_of_its_codec(owner: Owner) -> None:
    first = await owner.play()
    owner.peer.detach(first)
    owner.attach("b")
    assert len(owner.connection.sections) == 1
    other = Stream("c", "engine/Video", "video", owner.publisher, ("video/H264",), Counters())
    owner.peer.attach(other)
    assert len(owner.connection.sections) == 2


async def test_a_full_peer_takes_no_more_and_goes_on(owner: Owner) -> None:
    owner.connection.room = 1
    owner.attach("a")
    with pytest.raises(TooManySections):
        owner.attach("b")
    await owner.answer()
    assert not owner.peer.ended


async def test_a_stale_answer_and_a_stale_candidate_are_refused_and_change_nothing(owner: Owner) -> None:
    stream = await owner.play()
    owner.peer.detach(stream)
    await settle()
    for generation in (1, 3):
        with pytest.raises(UnexpectedAnswer):
            await owner.answer(generation)
    with pytest.raises(StaleGeneration):
        await owner.trickle("candidate", generation=3)
    await owner.answer(2)
    with pytest.raises(StaleGeneration):
        await owner.trickle("candidate", generation=1)
    assert not owner.peer.ended


async def test_candidates_of_the_answer_come_before_those_that_were_held(owner: Owner) -> None:
    owner.attach()
    await settle()
    await owner.trickle("early")
    await owner.trickle(None)
    with pytest.raises(InvalidCandidate):
        await owner.trickle("garbage")
    assert owner.connection.candidates == []
    await owner.answer(sdp="answer inside")
    assert owner.connection.candidates == ["inside", "early"]
    await owner.trickle("late")
    await owner.trickle(None)
    assert owner.connection.candidates[-1] == "late"
    with pytest.raises(InvalidCandidate):
        await owner.trickle("garbage")


async def test_candidates_are_bounded(owner: Owner) -> None:
    owner.attach()
    await owner.answer()
    for number in range(64):
        await owner.trickle(str(number))
    with pytest.raises(TooManyCandidates):
        await owner.trickle("one more")


async def test_an_answer_that_cannot_be_used_ends_the_peer_for_good(owner: Owner) -> None:
    owner.attach()
    with pytest.raises(InvalidDescription, match="it is garbage"):
        await owner.answer(sdp="garbage")
    assert owner.reasons == ["it is garbage"]
    assert owner.peer.ended
    with pytest.raises(UnknownPeer):
        await owner.answer()
    with pytest.raises(UnknownPeer):
        await owner.trickle("candidate")
    owner.peer.end_connection("again")
    assert owner.reasons == ["it is garbage"]


async def test_an_answer_is_applied_also_when_its_sender_leaves(owner: Owner) -> None:
    owner.attach()
    await settle()
    owner.connection.obstacle = asyncio.Event()
    answering = asyncio.create_task(owner.answer())
    await settle()
    await settle()
    answering.cancel()
    await asyncio.wait({answering})
    owner.connection.obstacle.set()
    await settle()
    await owner.trickle("late")
    assert owner.connection.candidates == ["late"]


@pytest.mark.parametrize(
    ("stuck", "limit", "reason"),
    [
        ("describe", PREPARE_TIMEOUT, "no description could be made in time"),
        ("answer", ANSWER_TIMEOUT, "the offer was not answered in time"),
        ("apply", APPLY_TIMEOUT, "the answer could not be applied in time"),
        ("connect", CONNECT_TIMEOUT, "no media path to the application was found"),
    ],
)
async def test_missed_deadline_ends_the_peer(owner: Owner, stuck: str, limit: float, reason: str) -> None:
    if stuck == "describe":
        owner.connection.obstacle = asyncio.Event()
    owner.attach()
    await settle()
    answering = None
    if stuck == "apply":
        owner.connection.obstacle = asyncio.Event()
    if stuck in {"apply", "connect"}:
        answering = asyncio.create_task(owner.answer())
        await settle()
    await owner.clock.advance(limit - 0.01)
    owner.peer.tick(owner.clock.now())
    assert owner.reasons == []
    await owner.clock.advance(0.02)
    owner.peer.tick(owner.clock.now())
    owner.peer.tick(owner.clock.now())
    assert owner.reasons == [reason]
    if stuck == "apply":
        assert answering is not None
        with pytest.raises(UnknownPeer):
            await answering


async def test_an_offer_that_is_ready_too_late_is_not_sent(owner: Owner) -> None:
    owner.connection.obstacle = asyncio.Event()
    owner.attach()
    await settle()
    owner.connection.obstacle.set()
    owner.peer.end_connection("over")
    await settle()
    assert [type(message) for message in owner.said] == [Bye]


async def test_an_answer_that_is_applied_too_late_counts_for_nothing(owner: Owner) -> None:
    owner.attach()
    await settle()
    owner.connection.obstacle = asyncio.Event()
    answering = asyncio.create_task(owner.answer())
    await settle()
    await settle()
    owner.connection.obstacle.set()
    owner.peer.end_connection("over")
    with pytest.raises(UnknownPeer):
        await answering


@pytest.mark.parametrize("failure", [OSError("no port"), None])
async def test_an_offer_that_cannot_be_made_ends_the_peer(
    owner: Owner, failure: Exception | None, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    if failure is None:

        async def describe(generation: int) -> tuple[str, tuple[()]]:
            return "x" * (SDP_LIMIT + 1), ()

        monkeypatch.setattr(owner.connection, "describe", describe)
    owner.connection.failure = failure
    with caplog.at_level(logging.CRITICAL):
        owner.attach()
        await settle()
    assert owner.reasons == ["no offer could be made"]


async def test_a_candidate_that_is_found_late_follows_the_offer(owner: Owner) -> None:
    owner.attach()
    await owner.answer()
    owner.connection.find("candidate:1 1 udp 1 203.0.114.7 5000 typ srflx")
    owner.connection.find(None)
    found, last = owner.said[-2:]
    assert isinstance(found, Candidate)
    assert (found.peer_id, found.generation, found.sdp_mid) == ("engine/p", 1, "0")
    assert isinstance(last, Candidate)
    assert not last.candidate
    owner.peer.end_connection("enough")
    owner.connection.find("candidate:1 1 udp 1 203.0.114.7 5001 typ srflx")
    assert isinstance(owner.said[-1], Bye), "nothing follows the end"


@pytest.mark.parametrize("refusal", [NoPath, PeerClosed])
async def test_bye_has_the_reason_without_a_network_path(
    owner: Owner, refusal: type[Exception], caplog: pytest.LogCaptureFixture
) -> None:
    owner.connection.failure = refusal("there is no way")
    owner.attach()
    await settle()
    assert owner.reasons == ["there is no way"]
    assert not caplog.records
