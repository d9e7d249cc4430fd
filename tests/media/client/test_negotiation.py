"""The answerer's half of the negotiation, message by message."""

from collections.abc import Callable

import pytest
from openrois_media.client.negotiation import (
    MAX_PEERS,
    MAX_WAITING_CANDIDATES,
    AddCandidate,
    Apply,
    Close,
    Effect,
    Negotiation,
    Open,
    SendAnswer,
    SendCandidate,
)
from openrois_signaling.messages import Answer, Candidate, Offer


def offer(generation: int = 1, peer_id: str = "p", replaces: str | None = None) -> Offer:
    return Offer(peer_id=peer_id, generation=generation, sdp=f"offer {generation}", streams=(), replaces=replaces)


def candidate(text: str | None, generation: int = 1, peer_id: str = "p") -> Candidate:
    return Candidate(peer_id=peer_id, generation=generation, candidate=text, sdp_mid="0")


def answer(generation: int = 1) -> SendAnswer:
    return SendAnswer(Answer(peer_id="p", generation=generation, sdp="answer"))


def own(text: str | None, generation: int = 1) -> SendCandidate:
    return SendCandidate(Candidate(peer_id="p", generation=generation, candidate=text, sdp_mid="0"))


Step = Callable[[Negotiation], list[Effect]]
OFFER: Step = lambda it: it.offer(offer())  # noqa: E731
ANSWERED: Step = lambda it: it.answered("p", 1, "answer", "0")  # noqa: E731
SECOND: Step = lambda it: it.offer(offer(2))  # noqa: E731
THIRD: Step = lambda it: it.offer(offer(3))  # noqa: E731
FOUND: Step = lambda it: it.candidate(candidate("c"))  # noqa: E731
GATHERED: Step = lambda it: it.gathered("p", "c")  # noqa: E731
REPLACING: Step = lambda it: it.offer(offer(replaces="o"))  # noqa: E731
BYE: Step = lambda it: it.end_peer("p", "bye")  # noqa: E731

TABLE: list[tuple[str, list[Step], Step, list[Effect]]] = [
    (
        "the first offer opens",
        [],
        lambda it: it.offer(offer(replaces="o")),
        [Open("p", "o"), Apply(offer(replaces="o"))],
    ),
    ("an answer is sent", [OFFER], ANSWERED, [answer()]),
    ("an answer of another generation is not", [OFFER], lambda it: it.answered("p", 2, "answer", "0"), []),
    ("an answer twice is sent once", [OFFER, ANSWERED], ANSWERED, []),
    ("an old offer is dropped", [OFFER, ANSWERED], OFFER, []),
    ("a newer offer is applied", [OFFER, ANSWERED], SECOND, [Apply(offer(2))]),
    ("one waits for the one before", [OFFER], SECOND, []),
    ("and is applied then", [OFFER, SECOND], ANSWERED, [answer(), Apply(offer(2))]),
    (
        "of those that wait the newest",
        [OFFER, SECOND, THIRD],
        ANSWERED,
        [answer(), Apply(offer(3))],
    ),
    ("a candidate waits for the answer", [OFFER], FOUND, []),
    (
        "and is added then",
        [OFFER, FOUND],
        ANSWERED,
        [answer(), AddCandidate("p", "c")],
    ),
    ("a later one at once", [OFFER, ANSWERED], FOUND, [AddCandidate("p", "c")]),
    ("the end of candidates", [OFFER, ANSWERED], lambda it: it.candidate(candidate("")), [AddCandidate("p", None)]),
    ("a candidate of the future", [OFFER, ANSWERED], lambda it: it.candidate(candidate("c", 2)), []),
    ("a candidate of a stranger", [OFFER], lambda it: it.candidate(candidate("c", peer_id="q")), []),
    ("an own candidate waits", [OFFER], GATHERED, []),
    ("and is sent behind the answer", [OFFER, GATHERED], ANSWERED, [answer(), own("c")]),
    ("a later one is sent at once", [OFFER, ANSWERED], lambda it: it.gathered("p", None), [own(None)]),
    ("an own candidate of no peer", [], GATHERED, []),
    ("a bye closes", [OFFER], BYE, [Close("p", "bye")]),
    ("a second bye does nothing", [OFFER, BYE], BYE, []),
    ("an ended peer gets no offer", [OFFER, BYE], SECOND, []),
    ("nor does one that ended before it began", [BYE], OFFER, []),
    ("the answer of an ended peer", [OFFER, BYE], ANSWERED, []),
]


@pytest.mark.parametrize(("before", "step", "effects"), [row[1:] for row in TABLE], ids=[row[0] for row in TABLE])
def test_table(before: list[Step], step: Step, effects: list[Effect]) -> None:
    negotiation = Negotiation()
    for each in before:
        each(negotiation)
    assert step(negotiation) == effects


def test_peers_are_bounded() -> None:
    negotiation = Negotiation()
    for number in range(MAX_PEERS):
        assert negotiation.offer(offer(peer_id=f"p{number}"))
    assert negotiation.offer(offer(peer_id="more")) == []
    negotiation.end_peer("p0", "bye")
    assert negotiation.offer(offer(peer_id="more"))


def test_waiting_candidates_are_bounded() -> None:
    negotiation = Negotiation()
    negotiation.offer(offer())
    for number in range(MAX_WAITING_CANDIDATES + 1):
        negotiation.candidate(candidate(f"c{number}"))
        negotiation.gathered("p", f"c{number}")
    assert len(negotiation.answered("p", 1, "answer", "0")) == 1 + 2 * MAX_WAITING_CANDIDATES


def test_a_lost_session_ends_the_negotiation_of_all_peers() -> None:
    negotiation = Negotiation()
    negotiation.offer(offer())
    negotiation.abandon()
    assert negotiation.answered("p", 1, "answer", "0") == []
    assert negotiation.offer(offer(2)) == []
