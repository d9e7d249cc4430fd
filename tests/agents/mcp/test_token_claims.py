"""Whose a token is, as it says itself."""

import base64
import json

import pytest
from openrois_agents.mcp.token_claims import expiry_of, rights_of

from tests.support.tokens import issue, part

pytestmark = pytest.mark.extra(name="mcp")


def test_tokens_of_the_same_subject_and_rights_are_alike() -> None:
    first, second = issue(1_000, sub="ann", jti="1"), issue(2_000, sub="ann", jti="2")
    assert rights_of(first) == rights_of(second) != ""
    for other in ({"sub": "bob"}, {"roles": ["viewer"]}, {"scope": ["robot/*"]}, {"rank": "person"}, {"iss": "x"}):
        assert rights_of(issue(1_000, **{"sub": "ann", **other})) != rights_of(first)
    assert expiry_of(first) == 1_900.0


@pytest.mark.parametrize("claims", [{}, {"sub": ""}, {"sub": 7}, [], "text", None])
def test_without_a_subject_there_are_no_rights(claims: object) -> None:
    token = f"e30.{part(json.dumps(claims).encode())}.x"
    assert rights_of(token) == ""
    assert expiry_of(token) is None


@pytest.mark.parametrize("expires", ["soon", True, -1, None])
def test_what_is_no_time_is_no_end(expires: object) -> None:
    assert expiry_of(issue(0, exp=expires)) is None


@pytest.mark.parametrize(
    "token", ["", "x", "a.b", "a.b.c.d", "a.!!!.c", "a.ä.c", f"a.{base64.urlsafe_b64encode(b'[' * 100_000).decode()}.c"]
)
def test_what_is_no_token_says_nothing(token: str) -> None:
    assert rights_of(token) == ""
    assert expiry_of(token) is None
