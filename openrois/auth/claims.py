"""The claims of a genuine token, read strictly: subject, roles, rank, scope and life time. Pure."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Final

from openrois.auth.principal import Principal, Role
from openrois.auth.ranks import Ranks
from openrois.auth.refusal import Refusal, TokenRefused

__all__ = ["LEEWAY", "MAX_LIFETIME", "ClaimRules", "read_claims"]

LEEWAY: Final = 30.0
"""Seconds by which the clocks of issuer and gateway may differ."""

MAX_LIFETIME: Final = 3600.0
"""Seconds that a token lasts at most, unless the gateway is configured otherwise."""

MAX_NAME: Final = 128
"""Characters of a subject, an issuer's or audience's name beside it, or a token's id."""

MAX_PATTERNS: Final = 64
"""Patterns in one scope."""

MAX_PATTERN: Final = 256
"""Characters of one pattern: an engine id, a slash and a component's name fit."""

_YEAR_5000: Final = 95_617_584_000


@dataclass(frozen=True, slots=True)
class ClaimRules:
    """Rules that every token has to meet.

    Attributes:
        issuer: what `iss` has to be; empty for whatever it is.
        audience: what has to be in `aud`; empty for a token that names no audience.
        max_lifetime: seconds from `iat` to `exp` at most.
        leeway: seconds by which the clocks may differ.
        ranks: those that a token may name; one that names none is of the lowest.
    """

    issuer: str = ""
    audience: str = ""
    max_lifetime: float = MAX_LIFETIME
    leeway: float = LEEWAY
    ranks: Ranks = field(default_factory=Ranks)


def read_claims(claims: Mapping[str, Any], rules: ClaimRules, now: float) -> Principal:
    """Return the principal that the claims of a genuine token describe.

    Args:
        claims: the token's payload.
        rules: what is asked of it.
        now: epoch seconds.

    Returns:
        The principal. It ends at `exp`; a token that is over by this clock and not yet by its issuer's ends with the
        leeway.

    Raises:
        TokenRefused: it is not good, or not yet, or no more.
    """
    subject = _text(claims.get("sub"))
    try:
        expires = _check_times(claims, rules, now)
        _check_issuer(claims, rules)
        token_id = "" if claims.get("jti") is None else _text(claims["jti"])
        roles = _roles(claims.get("roles"))
        scope = _scope(claims.get("scope"), roles)
        rank = _rank(claims.get("rank"), rules.ranks)
    except TokenRefused as refused:
        raise TokenRefused(refused.reason, subject) from None
    return Principal(subject, roles, scope, expires, token_id, rank)


def _check_times(claims: Mapping[str, Any], rules: ClaimRules, now: float) -> float:
    """Return the time from which on the token is not valid any more."""
    issued, expires = _time(claims.get("iat")), _time(claims.get("exp"))
    not_before = issued if claims.get("nbf") is None else _time(claims["nbf"])
    if expires + rules.leeway <= now:
        raise TokenRefused(Refusal.EXPIRED)
    if max(issued, not_before) > now + rules.leeway:
        raise TokenRefused(Refusal.NOT_YET)
    if not 0 < expires - issued <= rules.max_lifetime:
        raise TokenRefused(Refusal.LIFETIME)
    return expires if expires > now else expires + rules.leeway


def _check_issuer(claims: Mapping[str, Any], rules: ClaimRules) -> None:
    if rules.issuer and claims.get("iss") != rules.issuer:
        raise TokenRefused(Refusal.ISSUER)
    audience = claims.get("aud")
    named = [audience] if isinstance(audience, str) else audience
    if rules.audience:
        if not isinstance(named, list) or rules.audience not in named:
            raise TokenRefused(Refusal.AUDIENCE)
    elif named is not None:
        # RFC 7519, 4.1.3: a party that does not know its own name must refuse a token with an audience.
        raise TokenRefused(Refusal.AUDIENCE)


def _time(value: object) -> float:
    """Return epoch seconds; a bool is an int in Python and none in JSON."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise TokenRefused(Refusal.CLAIM)
    # No comparison holds of what is not a number; an int may be too large for a float.
    if not 0 <= value <= _YEAR_5000:
        raise TokenRefused(Refusal.CLAIM)
    return float(value)


def _text(value: object, longest: int = MAX_NAME) -> str:
    # It stands in logs: a line break in it would look like a line of its own. In the list of revoked subjects blanks at
    # its ends are dropped: a subject with some could not be revoked.
    is_name = isinstance(value, str) and 0 < len(value) <= longest and value.isprintable() and value == value.strip()
    if not is_name:
        raise TokenRefused(Refusal.CLAIM)
    return str(value)


def _roles(value: object) -> frozenset[Role]:
    names = [value] if isinstance(value, str) else value
    if not isinstance(names, list) or not 0 < len(names) <= len(Role):
        raise TokenRefused(Refusal.CLAIM)
    known = {role.value: role for role in Role}
    if not all(isinstance(name, str) and name in known for name in names):
        raise TokenRefused(Refusal.CLAIM)
    return frozenset(known[name] for name in names)


def _rank(value: object, ranks: Ranks) -> str:
    if value is None:
        return ranks.lowest
    if not isinstance(value, str):
        raise TokenRefused(Refusal.CLAIM)
    if value not in ranks:
        raise TokenRefused(Refusal.RANK)
    return value


def _scope(value: object, roles: frozenset[Role]) -> tuple[str, ...]:
    if value is None:
        return ("*",) if Role.ADMINISTRATOR in roles else ()
    patterns = value.split() if isinstance(value, str) else value
    if not isinstance(patterns, list) or len(patterns) > MAX_PATTERNS:
        raise TokenRefused(Refusal.CLAIM)
    return tuple(dict.fromkeys(_text(pattern, MAX_PATTERN) for pattern in patterns))
