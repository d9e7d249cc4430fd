"""How many applications are streamed to, and whose place is whose."""

from typing import Any

import pytest
from openrois_streaming.network.session_limits import SessionLimits, kept_by_default

RULES = SessionLimits(applications=4, kept_for_operators=2, answer_time=2.0)


@pytest.mark.parametrize(
    ("taken", "viewer", "operator"),
    [
        ([], True, True),
        ([False], True, True),
        ([False, False], False, True),
        ([False, False, True], False, True),
        ([False, False, True, True], False, False),
        ([True, True, True], True, True),
        ([True, True, True, True], False, False),
    ],
)
def test_those_that_may_not_bind_leave_places_free(taken: list[bool], viewer: bool, operator: bool) -> None:
    assert (RULES.has_room(taken, False), RULES.has_room(taken, True)) == (viewer, operator)


TAKEN = {"viewer 1": False, "viewer 2": False, "operator 1": True, "operator 2": True}


@pytest.mark.parametrize(
    ("unanswered", "viewer", "operator"),
    [
        ({}, None, None),
        ({"viewer 1": 1.9, "operator 1": 1.9}, None, None),
        ({"viewer 1": 2.0, "viewer 2": 2.5}, "viewer 2", "viewer 2"),
        ({"operator 1": 9.0}, None, "operator 1"),
        ({"operator 1": 9.0, "operator 2": 10.0, "viewer 1": 2.0}, "viewer 1", "viewer 1"),
    ],
)
def test_whose_offer_is_unanswered_for_longest_gives_up_its_place(
    unanswered: dict[str, float], viewer: str | None, operator: str | None
) -> None:
    assert RULES.displaced(TAKEN, unanswered, False) == viewer
    assert RULES.displaced(TAKEN, unanswered, True) == operator


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"applications": 0, "kept_for_operators": 0}, "--applications must be between 1 and 4096, not 0"),
        ({"applications": 5000}, "--applications must be between 1 and 4096, not 5000"),
        ({"applications": 16}, "--kept-for-operators must be between 0 and 15, below --applications, not 16"),
        ({"kept_for_operators": -1}, "--kept-for-operators must be between 0 and 63, below --applications, not -1"),
        ({"answer_time": -1.0}, "--answer-time must be between 0 and 60 seconds, not -1.0"),
        ({"answer_time": 61.0}, "--answer-time must be between 0 and 60 seconds, not 61.0"),
    ],
)
def test_rules_that_cannot_be(wrong: dict[str, Any], said: str) -> None:
    with pytest.raises(ValueError, match=said):
        SessionLimits(**wrong)


@pytest.mark.parametrize(("applications", "kept"), [(1, 0), (8, 2), (64, 16), (4096, 16)])
def test_a_quarter_of_few_places_is_kept_for_operators(applications: int, kept: int) -> None:
    assert kept_by_default(applications) == kept
