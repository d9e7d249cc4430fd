"""Verifying JSON Web Tokens: the header without trust, the signature with a key of ours, then the claims. Pure."""

import json
import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any, Final

import jwt

from openrois.auth.claims import ClaimRules, read_claims
from openrois.auth.keys import ALGORITHMS, KeySource, KeysUnavailable, VerificationKey
from openrois.auth.principal import Principal
from openrois.auth.refusal import Refusal, TokenRefused
from openrois.types.access import MAX_TOKEN

__all__ = ["TokenVerifier", "check_signature", "read_header"]

_MAX_KEY_ID: Final = 256
# Base64 decoders skip what is none: the same token must not have many spellings.
_SHAPE: Final = re.compile(r"[A-Za-z0-9_-]+\.[A-Za-z0-9_-]+\.[A-Za-z0-9_-]+")
_STRANGE: Final = frozenset({"crit", "b64", "enc", "zip", "jwk", "jku", "x5u", "x5c"})
_SIGNATURES: Final = jwt.PyJWS()


@dataclass(frozen=True, slots=True)
class TokenVerifier:
    """Verifies tokens and returns their principals.

    Attributes:
        keys: where the issuer's keys come from.
        rules: what is asked of the claims.
        clock: epoch seconds.
        is_revoked: whether a principal's token is revoked although it is genuine.
    """

    keys: KeySource
    rules: ClaimRules
    clock: Callable[[], float]
    is_revoked: Callable[[Principal], bool] = lambda _principal: False

    async def verify(self, token: str) -> Principal:
        """Return the principal of a token.

        Raises:
            TokenRefused: it is not good; nothing tells the other side why.
        """
        algorithm, key_id = read_header(token)
        try:
            keys = await self.keys.find(key_id)
        except KeysUnavailable:
            raise TokenRefused(Refusal.KEYS_UNAVAILABLE) from None
        if not keys:
            raise TokenRefused(Refusal.UNKNOWN_KEY)
        claims = check_signature(token, algorithm, keys)
        principal = read_claims(claims, self.rules, self.clock())
        if self.is_revoked(principal):
            raise TokenRefused(Refusal.REVOKED, principal.subject)
        return principal


def read_header(token: str) -> tuple[str, str]:
    """Return what the header of a token names: the algorithm, and the key's id or nothing. Nothing of it is trusted.

    Raises:
        TokenRefused: it is no token, or asks for what is not supported here.
    """
    if len(token) > MAX_TOKEN or _SHAPE.fullmatch(token) is None:
        raise TokenRefused(Refusal.MALFORMED)
    try:
        header = _json_object(jwt.utils.base64url_decode(token.partition(".")[0]))
    except ValueError:
        raise TokenRefused(Refusal.MALFORMED) from None
    if not _STRANGE.isdisjoint(header) or str(header.get("typ", "JWT")).lower() not in ("jwt", "at+jwt"):
        raise TokenRefused(Refusal.HEADER)
    algorithm, key_id = header.get("alg"), header.get("kid", "")
    if not isinstance(algorithm, str) or algorithm not in ALGORITHMS:
        raise TokenRefused(Refusal.ALGORITHM)
    if not isinstance(key_id, str) or len(key_id) > _MAX_KEY_ID:
        raise TokenRefused(Refusal.HEADER)
    return algorithm, key_id


def check_signature(token: str, algorithm: str, keys: Iterable[VerificationKey]) -> dict[str, Any]:
    """Return the payload of a token that one of the keys has signed.

    Args:
        token: as `read_header` takes it.
        algorithm: what its header says.
        keys: each is for one algorithm; one that is for another is not tried.

    Raises:
        TokenRefused: none of the keys has signed it, or it carries no object.
    """
    refusal = Refusal.ALGORITHM
    for key in keys:
        if key.algorithm != algorithm:
            continue
        try:
            payload = _SIGNATURES.decode(token, key.material, algorithms=[key.algorithm])
        except (jwt.PyJWTError, ValueError):
            refusal = Refusal.SIGNATURE
            continue
        try:
            return _json_object(payload)
        except ValueError:
            raise TokenRefused(Refusal.MALFORMED) from None
    raise TokenRefused(refusal)


def _json_object(content: bytes) -> dict[str, Any]:
    """Read a JSON object in which every name stands once. Raises ValueError."""
    try:
        found = json.loads(content, object_pairs_hook=_unique, parse_constant=_no_constant)
    except RecursionError:
        raise ValueError("it is nested too deeply") from None
    if not isinstance(found, dict):
        raise ValueError("it is no object")
    return found


def _unique(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    found = dict(pairs)
    if len(found) != len(pairs):
        raise ValueError("a name stands twice")
    return found


def _no_constant(name: str) -> float:
    raise ValueError(f"{name} is no JSON")
