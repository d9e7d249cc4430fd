"""Reads who a token is of, and until when, without judging it: the gateway does that. Pure."""

import base64
import binascii
import json
from typing import Any, Final

__all__ = ["expiry_of", "rights_of"]

_TIMES: Final = frozenset({"exp", "iat", "nbf", "jti"})
"""Claims by which two tokens of the same principal with the same rights differ."""

_NEVER: Final = 1e12
"""A time that no token can mean."""


def rights_of(token: str) -> str:
    """Return a text that is the same for all tokens of one subject with the same rights; empty where none can be read.

    It is as good as the token: whether that is genuine is the gateway's to say.
    """
    claims = _claims(token)
    if not isinstance(claims.get("sub"), str) or not claims["sub"]:
        return ""
    return json.dumps({name: value for name, value in claims.items() if name not in _TIMES}, sort_keys=True)


def expiry_of(token: str) -> float | None:
    """Return the time, in seconds of the epoch, at which a token ends; None where it does not say."""
    expires = _claims(token).get("exp")
    if not isinstance(expires, int | float) or isinstance(expires, bool) or not 0 <= expires < _NEVER:
        return None
    return float(expires)


def _claims(token: str) -> dict[str, Any]:
    parts = token.split(".")
    if len(parts) != 3:
        return {}
    try:
        read = json.loads(base64.urlsafe_b64decode(parts[1] + "=" * (-len(parts[1]) % 4)))
    except (ValueError, binascii.Error, RecursionError):
        return {}
    return read if isinstance(read, dict) else {}
