"""Which requests over HTTP are looked at: the host that they name, the page that they come from, the token. Pure."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Final

__all__ = ["GuardRules", "Refused", "bearer_of", "host_rules"]

MAX_TOKEN: Final = 8_192
"""Characters of a token."""

_LOOPBACK: Final = frozenset({"127.0.0.1", "localhost", "[::1]"})
_SCHEME: Final = "bearer "

Headers = Iterable[tuple[bytes, bytes]]


class Refused(Exception):
    """A request that is not served; the text says why, and nothing that was in it.

    Attributes:
        status: of the answer.
    """

    def __init__(self, status: int, sentence: str) -> None:
        super().__init__(sentence)
        self.status = status


@dataclass(frozen=True, slots=True)
class GuardRules:
    """What a request has to name.

    Attributes:
        hosts: names of this server, as in the header Host without a port.
        origins: pages that may send requests; none unless one is allowed.
    """

    hosts: frozenset[str]
    origins: frozenset[str] = frozenset()

    def check(self, headers: Headers) -> None:
        """Do nothing where a request is for this server, and from a program or a page that is allowed.

        Raises:
            Refused: it is not.
        """
        hosts = _values(headers, b"host")
        if len(hosts) != 1 or _without_port(hosts[0]) not in self.hosts:
            # A page may have bound a name of its own to this address.
            raise Refused(421, "this server is not called so: allow the name with --allow-host")
        origins = _values(headers, b"origin")
        if origins and (len(origins) > 1 or origins[0].lower() not in self.origins):
            raise Refused(403, "this page may not use the server: allow its origin with --allow-origin")


def host_rules(host: str, allow_hosts: Iterable[str], allow_origins: Iterable[str]) -> GuardRules:
    """Return the rules for a server.

    Args:
        host: at which it listens.
        allow_hosts: further names by which it is called.
        allow_origins: pages that may use it, as `https://app.example.org`.
    """
    own = f"[{host}]" if ":" in host else host
    return GuardRules(
        hosts=_LOOPBACK | {own.lower()} | {name.lower() for name in allow_hosts},
        origins=frozenset(origin.lower().rstrip("/") for origin in allow_origins),
    )


def bearer_of(headers: Headers) -> str:
    """Return the bearer token of a request.

    Raises:
        Refused: it has none, several, or what cannot be one.
    """
    shown = _values(headers, b"authorization")
    if len(shown) != 1 or not shown[0].lower().startswith(_SCHEME):
        raise Refused(401, "each caller shows a token of its own: Authorization: Bearer TOKEN")
    token = shown[0][len(_SCHEME) :].strip(" ")
    if not token or len(token) > MAX_TOKEN or not token.isascii() or not token.isprintable() or " " in token:
        raise Refused(401, "what was shown as a token is none")
    return token


def _values(headers: Headers, name: bytes) -> list[str]:
    return [value.decode("latin-1") for each, value in headers if each.lower() == name]


def _without_port(host: str) -> str:
    name, colon, port = host.lower().rpartition(":")
    return name if colon and port.isdigit() else host.lower()
