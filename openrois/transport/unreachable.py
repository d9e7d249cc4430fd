"""Explains why a gateway cannot be reached, in one sentence with the remedy."""

import ssl
from typing import Final

from websockets.exceptions import InvalidHandshake, InvalidStatus

from openrois.transport.websocket import refusal

__all__ = ["unreachable"]

_UNAUTHORIZED: Final = 401
_WHOEVER_SIGNED_IT: Final = frozenset({9, 10, 62, 64})
"""OpenSSL's codes of certificates that no authority makes good: of another time, or for another name or address."""


def unreachable(url: str, error: Exception, *, remedies: tuple[str, str]) -> str:
    """Return why `url` could not be dialled.

    Args:
        url: the address, without secrets.
        error: what `openrois.transport.websocket.dial` raised.
        remedies: what gives a token, and what names authorities, in the words of the caller.
    """
    by_token, by_authority = remedies
    match error:
        case InvalidStatus(response=response):
            remedy = f" ({by_token})" if response.status_code == _UNAUTHORIZED else ""
            return f"{url} answered {refusal(error)}{remedy}"
        case InvalidHandshake():
            encrypted = " (or one with TLS: wss://)" if url.startswith("ws:") else ""
            return f"what answers at {url} is no gateway{encrypted}: {error}"
        case ssl.SSLCertVerificationError():
            remedy = "" if error.verify_code in _WHOEVER_SIGNED_IT else f" ({by_authority})"
            return f"no gateway is reached at {url}: {refusal(error)}{remedy}"
        case ssl.SSLError():
            return f"no TLS is spoken at {url}; without it the address begins with ws:// ({error.reason or error})"
        case TimeoutError():
            return f"nothing answers at {url} in time"
        case OSError():
            return f"no gateway answers at {url}; `openrois gateway` starts one here ({error.strerror or error})"
        case _:
            return f"{url} is not dialled: {error}"
