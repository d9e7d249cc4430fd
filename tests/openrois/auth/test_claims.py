"""Claims: strictly read, and every one of them."""

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from openrois.auth.claims import MAX_PATTERNS, ClaimRules, read_claims
from openrois.auth.principal import Role
from openrois.auth.ranks import Ranks
from openrois.auth.refusal import Refusal, TokenRefused
from tests.support.tokens import claims_of

NOW = 1_700_000_000.0


def reason(rules: ClaimRules | None = None, **others: object) -> Refusal | None:
    try:
        read_claims(claims_of(NOW, **others), rules or ClaimRules(), NOW)
    except TokenRefused as refused:
        return refused.reason
    return None


@pytest.mark.parametrize("name", ["sub", "exp", "iat", "roles"])
def test_what_has_to_be_there(name: str) -> None:
    for value in (..., None):
        others: dict[str, Any] = {name: value}
        assert reason(**others) is Refusal.CLAIM


@pytest.mark.parametrize(
    "claims",
    [
        {"sub": ""},
        {"sub": 7},
        {"sub": ["alice"]},
        {"sub": "a" * 129},
        {"sub": "alice\nroot"},
        {"sub": "alice "},
        {"sub": " alice"},
        {"jti": "t1 "},
        {"sub": "alice\u202eecila"},
        {"exp": "1700000900"},
        {"exp": True},
        {"exp": [1]},
        {"exp": -1},
        {"exp": 10**30},
        {"exp": 1e300},
        {"iat": -(10**400)},
        {"iat": "now"},
        {"nbf": "now"},
        {"nbf": False},
        {"jti": ""},
        {"jti": 7},
        {"jti": "x" * 129},
        {"roles": []},
        {"roles": ""},
        {"roles": "root"},
        {"roles": "operator viewer"},
        {"roles": "Operator"},
        {"roles": ["operator", "root"]},
        {"roles": ["operator", 1]},
        {"roles": [["operator"]]},
        {"roles": {"operator": True}},
        {"roles": ["viewer"] * (len(Role) + 1)},
        {"roles": 1},
        {"scope": 1},
        {"scope": {"avatar/*": True}},
        {"scope": [1]},
        {"scope": [""]},
        {"scope": ["a" * 257]},
        {"scope": ["a\n"]},
        {"scope": ["a"] * (MAX_PATTERNS + 1)},
        {"scope": "a " * (MAX_PATTERNS + 1)},
    ],
    ids=str,
)
def test_what_is_no_such_claim(claims: dict[str, Any]) -> None:
    assert reason(**claims) is Refusal.CLAIM


def test_how_long_a_token_may_last() -> None:
    assert reason(exp=NOW + 3600) is None
    assert reason(exp=NOW + 3601) is Refusal.LIFETIME
    assert reason(iat=NOW - 3000, exp=NOW + 601) is Refusal.LIFETIME
    assert reason(iat=NOW + 10, exp=NOW + 10) is Refusal.LIFETIME
    assert reason(iat=NOW + 20, exp=NOW + 10) is Refusal.LIFETIME
    assert reason(exp=90_000_000_000) is Refusal.LIFETIME
    assert reason(ClaimRules(max_lifetime=86400), exp=NOW + 86400) is None


def test_a_session_ends_when_its_token_does() -> None:
    for exp, end in ((NOW + 10, NOW + 10), (NOW - 10, NOW + 20)):
        assert read_claims(claims_of(NOW, iat=NOW - 60, exp=exp), ClaimRules(), NOW).expires == end


@pytest.mark.parametrize(
    ("configured", "claimed", "good"),
    [
        ("", ..., True),
        ("", None, True),
        ("", "gateway", False),
        ("", [], False),
        ("gateway", "gateway", True),
        ("gateway", ["other", "gateway"], True),
        ("gateway", ..., False),
        ("gateway", "other", False),
        ("gateway", ["other"], False),
        ("gateway", "gateway2", False),
        ("gateway", {"gateway": 1}, False),
        ("gateway", 7, False),
    ],
)
def test_the_audience_has_to_match(configured: str, claimed: object, good: bool) -> None:
    assert reason(ClaimRules(audience=configured), aud=claimed) is (None if good else Refusal.AUDIENCE)


def test_the_issuer_has_to_match() -> None:
    rules = ClaimRules(issuer="https://issuer.example")
    assert reason(rules, iss="https://issuer.example") is None
    for other in (..., None, "", "https://issuer.example/", "http://issuer.example", ["https://issuer.example"]):
        assert reason(rules, iss=other) is Refusal.ISSUER
    assert reason(iss="any") is None


@pytest.mark.parametrize(
    ("claimed", "roles", "scope"),
    [
        ("avatar/* lamp/lamp", "viewer", ("avatar/*", "lamp/lamp")),
        (["avatar/*", "avatar/*"], ["viewer", "adapter"], ("avatar/*",)),
        ("", "operator", ()),
        (..., ["operator", "viewer"], ()),
        (..., "administrator", ("*",)),
        ([], "administrator", ()),
        (["lamp/*"], "administrator", ("lamp/*",)),
        (..., "adapter", ()),
    ],
)
def test_roles_and_scope(claimed: object, roles: object, scope: tuple[str, ...]) -> None:
    principal = read_claims(claims_of(NOW, scope=claimed, roles=roles), ClaimRules(), NOW)
    assert principal.scope == scope
    assert principal.roles == {Role(name) for name in ([roles] if isinstance(roles, str) else roles)}  # type: ignore[attr-defined]


_JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(), inner, max_size=3),
    max_leaves=5,
)


@given(st.dictionaries(st.sampled_from(["sub", "exp", "iat", "nbf", "jti", "roles", "scope", "aud", "iss"]), _JSON))
def test_any_claims_are_read_or_refused(others: dict[str, Any]) -> None:
    assert reason(**others) in (None, *Refusal)


def test_the_audit_records_the_principal() -> None:
    with pytest.raises(TokenRefused) as refused:
        read_claims(claims_of(NOW, roles="root"), ClaimRules(), NOW)
    assert refused.value.subject == "alice"


@pytest.mark.parametrize(
    ("claimed", "rank"), [(..., "script"), (None, "script"), ("person", "person"), ("agent", "agent")]
)
def test_a_rank(claimed: object, rank: str) -> None:
    assert read_claims(claims_of(NOW, rank=claimed), ClaimRules(), NOW).rank == rank


@pytest.mark.parametrize(
    ("claimed", "refusal"),
    [
        ("emperor", Refusal.RANK),
        ("Person", Refusal.RANK),
        ("", Refusal.RANK),
        ("person agent", Refusal.RANK),
        (0, Refusal.CLAIM),
        (True, Refusal.CLAIM),
        (["person"], Refusal.CLAIM),
    ],
)
def test_no_rank(claimed: object, refusal: Refusal) -> None:
    assert reason(rank=claimed) is refusal


def test_ranks_are_the_gateways() -> None:
    rules = ClaimRules(ranks=Ranks(("crew", "guest")))
    assert reason(rules, rank="person") is Refusal.RANK
    assert reason(rules, rank="crew") is None
    assert read_claims(claims_of(NOW), rules, NOW).rank == "guest"
