"""Tokens that are good, and every way that we know to make a bad one."""

from functools import cache
from typing import Any

import pytest
from cryptography.hazmat.primitives.serialization import Encoding, NoEncryption, PrivateFormat
from hypothesis import given
from hypothesis import strategies as st

from openrois.auth.claims import ClaimRules
from openrois.auth.keys import KeysUnavailable, StoredKeys, VerificationKey, parse_key
from openrois.auth.principal import Principal, Role
from openrois.auth.refusal import Refusal, TokenRefused
from openrois.auth.tokens import TokenVerifier, check_signature, read_header
from tests.support.forgeries import forgeries
from tests.support.tokens import SECRET, Keys, b64, claims_of, forge, issue, part, pem

pytestmark = pytest.mark.extra(name="gateway")

NOW = 1_700_000_000.0
GOOD = claims_of(NOW)
HS: dict[str, object] = {"alg": "HS256", "typ": "JWT"}


@cache
def keys() -> Keys:
    return Keys()


@cache
def trusted() -> dict[str, VerificationKey]:
    return {
        "HS256": parse_key(SECRET),
        "RS256": parse_key(pem(keys().rsa)),
        "ES256": parse_key(pem(keys().p256)),
        "EdDSA": parse_key(pem(keys().ed25519)),
    }


def verifier(*algorithms: str, **rules: Any) -> TokenVerifier:
    chosen = tuple(trusted()[name] for name in algorithms or ("HS256",))
    return TokenVerifier(StoredKeys(chosen), ClaimRules(**rules), lambda: NOW)


async def refusal(token: str, *algorithms: str) -> Refusal:
    with pytest.raises(TokenRefused) as refused:
        await verifier(*algorithms).verify(token)
    assert str(refused.value) == refused.value.reason.value
    return refused.value.reason


@pytest.mark.parametrize("algorithm", ["HS256", "RS256", "ES256", "EdDSA"])
async def test_good_tokens(algorithm: str) -> None:
    key = {"HS256": SECRET, "RS256": keys().rsa, "ES256": keys().p256, "EdDSA": keys().ed25519}[algorithm]
    token = issue(NOW, key, jti="t1")
    expected = Principal("alice", frozenset({Role.OPERATOR}), ("*",), NOW + 900, "t1", "script")
    assert await verifier(algorithm).verify(token) == expected
    assert await verifier("HS256", "RS256", "ES256", "EdDSA").verify(token) == expected
    for other in {"HS256", "RS256", "ES256", "EdDSA"} - {algorithm}:
        assert await refusal(token, other) is Refusal.ALGORITHM


async def test_after_a_rotation_both_keys_are_good() -> None:
    both = StoredKeys((parse_key("x" * 40), parse_key(SECRET)))
    assert (await TokenVerifier(both, ClaimRules(), lambda: NOW).verify(issue(NOW))).subject == "alice"


FORGERIES = forgeries(keys(), NOW)


def test_there_are_many_forgeries() -> None:
    assert len(FORGERIES) >= 60


@pytest.mark.parametrize("name", FORGERIES)
async def test_forged_tokens(name: str) -> None:
    token, reason = FORGERIES[name]
    assert await refusal(token, "HS256", "RS256", "ES256", "EdDSA") is reason


async def test_the_secret_of_a_gateway_is_no_public_key() -> None:
    """With a public key alone, HS256 is nothing: whatever it was made with."""
    for secret in (pem(keys().rsa), pem(keys().rsa).strip(), pem(keys().rsa).encode()):
        assert await refusal(forge(HS, GOOD, secret), "RS256") is Refusal.ALGORITHM


TIMES: list[tuple[float, float, float | None]] = [
    (issued, expires, not_before)
    for issued, expires in [(0, 900), (-900, 0), (-600, -1), (-600, -29), (0, 3600), (29, 900), (-3600, -30)]
    for not_before in (None, 0.0, 29.0)
]


@pytest.mark.parametrize("skew", [-30.0, -15.0, 0.0, 15.0, 30.0])
@pytest.mark.parametrize(("issued", "expires", "not_before"), TIMES)
async def test_times_and_clocks(issued: float, expires: float, not_before: float | None, skew: float) -> None:
    """The gateway's clock is ahead of the issuer's by `skew`: what is good is decided by both and the leeway."""
    now = NOW + skew
    claims = claims_of(NOW, iat=NOW + issued, exp=NOW + expires)
    if not_before is not None:
        claims["nbf"] = NOW + not_before
    begins = NOW + max(issued, issued if not_before is None else not_before)
    tried = TokenVerifier(StoredKeys((trusted()["HS256"],)), ClaimRules(), lambda: now)
    if NOW + expires + 30 <= now:
        expected: Refusal | None = Refusal.EXPIRED
    elif begins > now + 30:
        expected = Refusal.NOT_YET
    else:
        expected = None
    if expected is None:
        principal = await tried.verify(forge(HS, claims))
        assert principal.expires is not None
        assert now < principal.expires <= now + 3600 + 30
    else:
        with pytest.raises(TokenRefused) as refused:
            await tried.verify(forge(HS, claims))
        assert (refused.value.reason, refused.value.subject) == (expected, "alice")


async def test_an_unknown_key_and_keys_that_are_unavailable() -> None:
    class Nothing:
        async def find(self, key_id: str) -> tuple[VerificationKey, ...]:
            if key_id:
                raise KeysUnavailable
            return ()

        def is_usable(self) -> bool:
            return False

    verifier = TokenVerifier(Nothing(), ClaimRules(), lambda: NOW)
    for header, reason in ((HS, Refusal.UNKNOWN_KEY), ({**HS, "kid": "k"}, Refusal.KEYS_UNAVAILABLE)):
        with pytest.raises(TokenRefused) as refused:
            await verifier.verify(forge(header, GOOD))
        assert refused.value.reason is reason


async def test_the_revoked() -> None:
    strict = TokenVerifier(StoredKeys((trusted()["HS256"],)), ClaimRules(), lambda: NOW, lambda p: p.token_id == "t2")
    assert (await strict.verify(issue(NOW, jti="t1"))).token_id == "t1"
    with pytest.raises(TokenRefused) as refused:
        await strict.verify(issue(NOW, jti="t2"))
    assert (refused.value.reason, refused.value.subject) == (Refusal.REVOKED, "alice")


@given(st.text(max_size=200) | st.from_regex(r"[\w-]{0,80}\.[\w-]{0,80}\.[\w-]{0,80}", fullmatch=True))
def test_any_text_is_read_or_refused(token: str) -> None:
    try:
        algorithm, _ = read_header(token)
        check_signature(token, algorithm, trusted().values())
    except TokenRefused:
        pass
    else:
        raise AssertionError(token)


@given(st.binary(max_size=200), st.sampled_from(["HS256", "RS256", "ES256", "EdDSA"]))
def test_any_signature_is_refused(signature: bytes, algorithm: str) -> None:
    token = f"{part({'alg': algorithm})}.{part(GOOD)}.{b64(signature or b'x')}"
    with pytest.raises(TokenRefused):
        check_signature(token, algorithm, trusted().values())


def test_nothing_shows_a_secret() -> None:
    assert SECRET not in repr(trusted())
    private = keys().rsa.private_bytes(Encoding.PEM, PrivateFormat.PKCS8, NoEncryption()).decode()
    with pytest.raises(ValueError, match="give a gateway the public key") as refused:
        parse_key(private)
    assert private[40:80] not in str(refused.value)
