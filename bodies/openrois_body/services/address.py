"""Addresses of servers that are sent what is said: another machine's only with TLS, unless that is allowed. Pure."""

from dataclasses import dataclass
from typing import Final
from urllib.parse import urlsplit

from openrois.auth.loopback import is_loopback

__all__ = ["ServiceAddress", "read_address"]

_VERSION: Final = "/v1"
_MAX: Final = 2048


@dataclass(frozen=True, slots=True)
class ServiceAddress:
    """The address of a server with an API like OpenAI's.

    Attributes:
        base: leads the addresses of what it does: `https://host/v1`, without a slash at its end.
    """

    base: str

    @property
    def origin(self) -> str:
        """The scheme, host and port."""
        parts = urlsplit(self.base)
        return f"{parts.scheme}://{parts.netloc}"

    @property
    def destination(self) -> str:
        """Where what is sent goes to: `origin`, or nothing where that is this machine."""
        return "" if is_loopback(urlsplit(self.base).hostname or "") else self.origin

    def url(self, path: str) -> str:
        """Return the address of something that it does, as `audio/speech`."""
        return f"{self.base}/{path}"


def read_address(
    text: str, path: str, *, unencrypted: bool = False, allowed_by: str = "--speech-unencrypted"
) -> ServiceAddress:
    """Read the address of a server.

    Args:
        text: `https://host`, `https://host/v1`, or the whole address of what is asked of it.
        path: what is asked of it, as `audio/speech`.
        unencrypted: whether another machine may be spoken to without TLS.
        allowed_by: the option that allows it.

    Raises:
        ValueError: it is no such address, carries credentials, or would be spoken to without TLS.
    """
    example = f"write one like https://example.org/v1 or http://127.0.0.1:8000{_VERSION}"
    try:
        parts = urlsplit(text)
        host, _ = parts.hostname, parts.port
    except ValueError:
        host = None
    if len(text) > _MAX or not text.isascii() or not text.isprintable() or " " in text:
        host = None
    if not host or parts.scheme not in {"http", "https"}:
        raise ValueError(f"{text[:80]!r} is no address of a server; {example}")
    if parts.username is not None or parts.password is not None:
        raise ValueError(
            f"credentials do not belong in an address, where logs would keep them; {example}, and a key file"
        )
    if parts.query or parts.fragment:
        raise ValueError(f"an address with ? or # is not understood; {example}")
    if parts.scheme == "http" and not unencrypted and not is_loopback(host):
        raise ValueError(
            f"{host} is not this machine, and what is said could be read on its way there; use https://, or allow it"
            f" with {allowed_by}"
        )
    named = parts.path.rstrip("/").removesuffix(f"/{path}")
    return ServiceAddress(f"{parts.scheme}://{parts.netloc}{named or _VERSION}")
