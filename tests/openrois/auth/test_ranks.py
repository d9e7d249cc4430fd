"""Ranks: their order, persons and programs, and names that are no ranks."""

import pytest

from openrois.auth.principal import LOCAL, Principal, Role
from openrois.auth.ranks import DEFAULT_RANKS, MAX_RANKS, Ranks


def of(rank: str) -> Principal:
    return Principal(rank or "none", frozenset({Role.OPERATOR}), ("*",), rank=rank)


PERSON, AGENT, SCRIPT, UNKNOWN, NONE = (of(rank) for rank in ("person", "agent", "script", "emperor", ""))


def test_the_first_is_above_all_behind_it() -> None:
    ranks = Ranks()
    pairs = [(one, other) for one in (PERSON, AGENT, SCRIPT) for other in (PERSON, AGENT, SCRIPT)]
    assert [pair for pair in pairs if ranks.is_above(*pair)] == [(PERSON, AGENT), (PERSON, SCRIPT), (AGENT, SCRIPT)]


@pytest.mark.parametrize("strange", [UNKNOWN, NONE], ids=["unknown", "none"])
def test_a_rank_that_is_not_known_counts_as_the_lowest(strange: Principal) -> None:
    ranks = Ranks()
    assert ranks.is_above(AGENT, strange)
    assert not ranks.is_above(SCRIPT, strange)
    assert not ranks.is_above(strange, SCRIPT)
    assert ranks.is_program(strange)
    assert not ranks.is_person(strange)


def test_those_of_the_first_are_persons_and_all_others_programs() -> None:
    ranks = Ranks()
    assert [ranks.is_person(each) for each in (PERSON, AGENT, SCRIPT)] == [True, False, False]
    assert [ranks.is_program(each) for each in (PERSON, AGENT, SCRIPT)] == [False, True, True]


def test_without_tokens_there_are_no_ranks() -> None:
    ranks = Ranks()
    assert not ranks.is_person(LOCAL)
    assert ranks.is_program(LOCAL)
    assert not any(ranks.is_above(LOCAL, each) for each in (PERSON, SCRIPT, LOCAL))
    assert [ranks.is_above(each, LOCAL) for each in (PERSON, SCRIPT)] == [True, False]


def test_only_persons_hand_back_and_without_tokens_what_no_person_has_stopped() -> None:
    ranks = Ranks()
    for stopped_by in ("ann", ""):
        assert [ranks.may_hand_back(each, stopped_by) for each in (PERSON, AGENT, NONE)] == [True, False, False]
    assert [ranks.may_hand_back(LOCAL, stopped_by) for stopped_by in ("ann", "")] == [False, True]


def test_of_one_rank_all_are_persons() -> None:
    ranks = Ranks(("anyone",))
    assert ranks.is_person(NONE)
    assert not ranks.is_above(of("anyone"), NONE)


def test_they_are_read_from_a_text() -> None:
    assert Ranks.parse("person, agent,script").names == DEFAULT_RANKS
    assert Ranks.parse("crew").lowest == "crew"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "is no rank"),
        ("person,,script", "is no rank"),
        ("a\nb", "is no rank"),
        ("x" * 33, "is no rank"),
        ("person,agent,person", "named twice"),
        (",".join(map(str, range(MAX_RANKS + 1))), "1 to 8 ranks, not 9"),
    ],
)
def test_what_are_no_ranks(text: str, words: str) -> None:
    with pytest.raises(ValueError, match=words):
        Ranks.parse(text)


def test_as_many_as_there_may_be() -> None:
    assert Ranks.parse(",".join(map(str, range(MAX_RANKS)))).lowest == "7"
