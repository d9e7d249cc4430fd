"""Issuing tokens with a key of one's own, for development and small deployments."""

import secrets
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import jwt

from openrois.auth.claims import MAX_NAME, MAX_PATTERN, MAX_PATTERNS, ClaimRules, read_claims
from openrois.auth.key_files import read_signing_key
from openrois.auth.principal import Role
from openrois.auth.ranks import Ranks
from openrois.auth.refusal import TokenRefused

__all__ = ["issue_token", "sign_token"]


def issue_token(
    key: Path,
    subject: str,
    roles: Sequence[Role],
    scope: Sequence[str],
    *,
    now: int,
    ttl: int,
    issuer: str = "",
    audience: str = "",
    rank: str = "",
) -> str:
    """Return a new token.

    Args:
        key: file of the key that signs it: a private key, or a secret for HS256.
        subject: the name of the application, adapter or person.
        roles: roles of the subject.
        scope: patterns of component references; without one an administrator sees everything, any other role nothing.
        now: epoch seconds.
        ttl: for how many seconds it is good.
        issuer: the claim `iss`; empty for none.
        audience: the claim `aud`; empty for none.
        rank: the claim `rank`; empty for none, which is the lowest.

    Raises:
        ValueError: the key cannot be used, or no gateway would take such a token.
    """
    algorithm, material = read_signing_key(key)
    return sign_token(
        algorithm,
        material,
        subject,
        roles,
        scope,
        now=now,
        ttl=ttl,
        issuer=issuer,
        audience=audience,
        rank=rank,
    )


def sign_token(
    algorithm: str,
    material: Any,
    subject: str,
    roles: Sequence[Role],
    scope: Sequence[str],
    *,
    now: int,
    ttl: int,
    issuer: str = "",
    audience: str = "",
    rank: str = "",
) -> str:
    """Return a new token, signed with a key that is at hand; the other arguments are those of `issue_token`.

    Raises:
        ValueError: no gateway would take such a token.
    """
    claims: dict[str, Any] = {
        "sub": subject,
        "iat": now,
        "exp": now + ttl,
        "jti": secrets.token_hex(16),
        "roles": [role.value for role in roles],
    }
    claims |= {"scope": list(scope)} if scope else {}
    claims |= {"iss": issuer} if issuer else {}
    claims |= {"aud": audience} if audience else {}
    claims |= {"rank": rank} if rank else {}
    ranks = Ranks((rank,)) if rank else Ranks()
    try:
        read_claims(claims, ClaimRules(issuer, audience, ttl, ranks=ranks), now)
    except TokenRefused:
        raise ValueError(
            f"a gateway would refuse this token: --sub must have 1 to {MAX_NAME} printable characters, "
            f"each pattern of a scope 1 to {MAX_PATTERN}, {MAX_PATTERNS} times at most"
        ) from None
    return jwt.encode(claims, material, algorithm)
