"""Whom a body attends to, and how long."""

import pytest
from hypothesis import given
from hypothesis import strategies as st
from openrois_body.attention.rule import DWELL, LOUDEST, NEAREST, PATIENCE, AttentionRule, Candidate


def ann(loudness: float = -100.0, face: float = 0.0) -> Candidate:
    return Candidate("ann", loudness, face)


def bob(loudness: float = -100.0, face: float = 0.0) -> Candidate:
    return Candidate("bob", loudness, face)


def after(rule: AttentionRule, mode: str, *candidates: Candidate, seconds: float, begin: float = 0.0) -> str:
    """Return whom the rule attends to when things stand so for a while."""
    for tenth in range(round(seconds * 10) + 1):
        rule.choose(mode, candidates, begin + tenth / 10)
    return rule.attended


def test_without_visitors_none_is_attended_to() -> None:
    rule = AttentionRule()
    assert rule.choose(NEAREST, (), 0.0) == ""
    assert rule.choose(NEAREST, (ann(),), 0.0) == "ann"
    assert rule.choose(NEAREST, (), 0.1) == ""


@pytest.mark.parametrize("mode", [NEAREST, LOUDEST, "somebody"])
def test_of_equals_the_first_is_attended_to_for_good(mode: str) -> None:
    assert after(AttentionRule(), mode, ann(), bob(), seconds=60.0) == "ann"
    assert after(AttentionRule(), mode, ann(-50.0), bob(-46.0), seconds=60.0) == "ann"


@pytest.mark.parametrize(
    ("mode", "near", "far"),
    [
        (LOUDEST, ann(-40.0), bob(-30.0)),
        (LOUDEST, ann(-40.0, face=0.5), bob(-30.0)),
        (NEAREST, ann(-40.0), bob(-30.0)),
        (NEAREST, ann(face=0.1), bob(face=0.2)),
        (NEAREST, ann(-10.0), bob(face=0.01)),
    ],
)
def test_a_clearly_better_one_is_attended_to_when_it_stays_so(mode: str, near: Candidate, far: Candidate) -> None:
    rule = AttentionRule()
    rule.choose(mode, (ann(),), 0.0)
    assert after(rule, mode, near, far, seconds=DWELL - 0.3, begin=0.1) == "ann"
    assert after(rule, mode, near, far, seconds=0.3, begin=DWELL) == "bob"


@pytest.mark.parametrize(
    ("mode", "near", "far"),
    [
        (LOUDEST, ann(-40.0), bob(-35.0)),
        (LOUDEST, ann(-90.0), bob(-46.0)),
        (NEAREST, ann(face=0.1), bob(face=0.12)),
        (NEAREST, ann(face=0.1), bob(-10.0)),
    ],
)
def test_one_that_is_hardly_better_is_not(mode: str, near: Candidate, far: Candidate) -> None:
    rule = AttentionRule()
    rule.choose(mode, (ann(),), 0.0)
    assert after(rule, mode, near, far, seconds=60.0) == "ann"


def test_a_short_noise_changes_nothing() -> None:
    rule = AttentionRule()
    for start in range(0, 60, 2):
        assert after(rule, LOUDEST, ann(), bob(), seconds=1.5, begin=start) == "ann"
        assert after(rule, LOUDEST, ann(), bob(-10.0), seconds=PATIENCE - 0.2, begin=start + 1.6) == "ann"


def test_one_that_is_named_is_attended_to_at_once_and_until_it_leaves() -> None:
    rule = AttentionRule()
    assert rule.choose(NEAREST, (ann(), bob()), 0.0) == "ann"
    assert rule.choose("bob", (ann(-5.0), bob()), 0.1) == "bob"
    assert after(rule, "bob", ann(-5.0, face=0.5), bob(), seconds=10.0, begin=0.2) == "bob"
    assert rule.choose("bob", (ann(),), 11.0) == "ann"


def test_one_that_leaves_is_replaced_at_once() -> None:
    rule = AttentionRule()
    rule.choose(NEAREST, (ann(), bob()), 0.0)
    assert rule.choose(NEAREST, (bob(),), 0.1) == "bob"


@given(
    st.lists(
        st.tuples(
            st.floats(0.1, 1.0),
            st.lists(st.builds(Candidate, st.sampled_from("abc"), st.floats(-100, 0), st.floats(0, 1)), max_size=3),
            st.sampled_from([NEAREST, LOUDEST, "a"]),
        ),
        max_size=60,
    )
)
def test_it_is_always_one_that_is_there_and_does_not_flap(steps: list[tuple[float, list[Candidate], str]]) -> None:
    rule, now, before, changed_at = AttentionRule(), 0.0, "", float("-inf")
    for passed, candidates, mode in steps:
        now += passed
        refs = {each.visitor_ref for each in candidates}
        attended = rule.choose(mode, candidates, now)
        assert attended in refs or (attended == "" and not refs)
        if attended != before:
            assert before not in refs or mode in refs or now - changed_at >= DWELL
            before, changed_at = attended, now
