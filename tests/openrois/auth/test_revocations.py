"""Revoked subjects and tokens."""

from contextlib import suppress

import pytest
from hypothesis import given
from hypothesis import strategies as st

from openrois.auth.principal import Principal, Role
from openrois.auth.revocations import MAX_REVOCATIONS, NOTHING_REVOKED, parse_revocations


def principal(subject: str, token_id: str = "") -> Principal:
    return Principal(subject, frozenset({Role.VIEWER}), (), None, token_id)


def test_subjects_and_tokens() -> None:
    revoked = parse_revocations("# left on Friday\nsub alice smith\n\n  jti t-7  \n")
    assert revoked.covers(principal("alice smith"))
    assert revoked.covers(principal("bob", "t-7"))
    assert not revoked.covers(principal("bob", "alice smith"))
    assert not revoked.covers(principal("t-7"))
    assert not NOTHING_REVOKED.covers(principal("alice smith", "t-7"))
    assert not revoked.covers(principal("bob"))


@pytest.mark.parametrize("text", ["alice", "sub", "sub ", "JTI x", "sub a\nkid 7"])
def test_a_line_that_says_something_else(text: str) -> None:
    with pytest.raises(ValueError, match=rf"line {len(text.splitlines())} is neither"):
        parse_revocations(text)


def test_how_many() -> None:
    with pytest.raises(ValueError, match="more than"):
        parse_revocations("sub x\n" * (MAX_REVOCATIONS + 1))


@given(st.text())
def test_any_text(text: str) -> None:
    with suppress(ValueError):
        parse_revocations(text)
