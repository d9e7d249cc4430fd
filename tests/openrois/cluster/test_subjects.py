"""Subjects: no name stands for more than itself."""

import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from openrois.cluster.subjects import MAX_NAME, Subjects, escaped

pytestmark = pytest.mark.extra(name="cluster")


@pytest.mark.parametrize(
    ("name", "token"),
    [
        ("gateway-1", "gateway-1"),
        ("a.b", "a_2eb"),
        ("*", "_2a"),
        (">", "_3e"),
        ("a_2eb", "a_5f2eb"),
        ("日", "_e6_97_a5"),
        (" \r\n", "_20_0d_0a"),
    ],
)
def test_a_name_is_one_token_without_wildcards(name: str, token: str) -> None:
    assert escaped(name) == token


@given(st.text(min_size=1, max_size=MAX_NAME // 4), st.text(min_size=1, max_size=MAX_NAME // 4))
def test_two_names_never_share_a_token(one: str, other: str) -> None:
    assert re.fullmatch(r"[A-Za-z0-9_-]+", escaped(one))
    assert (escaped(one) == escaped(other)) == (one == other)


@pytest.mark.parametrize("name", ["", "x" * (MAX_NAME + 1), "日" * 43, "\ud800"])
def test_what_is_no_name_is_refused(name: str) -> None:
    with pytest.raises(ValueError):
        escaped(name)


def test_all_subjects_stand_below_the_prefix() -> None:
    subjects = Subjects("site.1")
    assert subjects.beats == "site_2e1.beat.*"
    assert subjects.beat("a.b") == "site_2e1.beat.a_2eb"
    assert subjects.dial("a.b") == "site_2e1.dial.a_2eb"
    assert subjects.streams("0f") == "site_2e1.stream.0f.*"
    assert subjects.stream("0f", 7) == "site_2e1.stream.0f.7"
