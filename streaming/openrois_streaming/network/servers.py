"""STUN and TURN servers by their URLs (RFC 7064, RFC 7065). Pure."""

import ipaddress
import re
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Final, Literal

from openrois_signaling.messages import IceServer

SERVERS_LIMIT: Final = 4
"""Servers of each kind that are asked at a time; further ones would only repeat the same addresses."""

_URL: Final = re.compile(
    r"(?P<scheme>stuns?|turns?):"
    r"(?P<host>\[[0-9A-Fa-f:.]{2,45}\]|(?:[A-Za-z0-9_-]{1,63}\.){0,126}[A-Za-z0-9_-]{1,63}\.?)"
    r"(?::(?P<port>[0-9]{1,5}))?"
    r"(?:\?transport=(?P<transport>udp|tcp))?"
)
_PORTS: Final = {"stun": 3478, "turn": 3478, "turns": 5349}


class UnusableServer(ValueError):
    """URL of a server that cannot be used; the text says why, and repeats no credential."""


@dataclass(frozen=True, slots=True)
class StunServer:
    """STUN server, which reports the address under which this machine is seen."""

    url: str
    host: str
    port: int


@dataclass(frozen=True, slots=True)
class TurnServer:
    """TURN server, which relays UDP. `transport` is how it is reached."""

    url: str
    host: str
    port: int
    transport: Literal["udp", "tcp"]
    tls: bool
    username: str | None = None
    credential: str | None = field(default=None, repr=False)


def read_server(url: str, username: str | None = None, credential: str | None = None) -> StunServer | TurnServer:
    """Return the server of a URL.

    Raises:
        UnusableServer: the URL is malformed, or needs something that is not supported.
    """
    found = _URL.fullmatch(url)
    if found is None:
        raise UnusableServer(f"{url[:80]!r} is not a STUN or TURN URL, such as turn:turn.example.org:3478")
    scheme, host, transport = found["scheme"], found["host"].strip("[]"), found["transport"]
    if found["host"].startswith("["):
        _check_ipv6(host)
    if scheme == "stuns":
        raise UnusableServer(f"{url[:80]!r}: STUN over TLS is not supported: use stun:, which carries nothing secret")
    port = int(found["port"] or _PORTS[scheme])
    if not 0 < port < 2**16:
        raise UnusableServer(f"{url[:80]!r} has no valid port: use one between 1 and 65535")
    if scheme == "stun":
        if transport is not None:
            raise UnusableServer(f"{url[:80]!r}: a STUN URL has no transport (RFC 7064): leave ?transport= out")
        return StunServer(url, host, port)
    if scheme == "turns" and transport == "udp":
        raise UnusableServer(f"{url[:80]!r}: TURN over DTLS is not supported; use transport=tcp")
    by_tcp = transport == "tcp" or scheme == "turns"
    return TurnServer(url, host, port, "tcp" if by_tcp else "udp", scheme == "turns", username, credential)


def _check_ipv6(text: str) -> None:
    try:
        ipaddress.IPv6Address(text)
    except ValueError:
        raise UnusableServer(f"{text!r} is not an IPv6 address") from None


@dataclass(frozen=True, slots=True)
class Servers:
    """Servers that a peer connection asks, `SERVERS_LIMIT` of each kind at most, and why others are left out."""

    stun: tuple[StunServer, ...] = ()
    turn: tuple[TurnServer, ...] = ()
    unusable: tuple[str, ...] = ()

    def __bool__(self) -> bool:
        return bool(self.stun or self.turn)


def read_servers(given: Iterable[IceServer]) -> Servers:
    """Return the usable servers of a list as applications have it. An unusable one is left out with a reason."""
    stun: dict[tuple[str, int], StunServer] = {}
    turn: dict[tuple[str, int, str], TurnServer] = {}
    unusable: list[str] = []
    for server in given:
        for url in server.urls:
            try:
                read = read_server(url, server.username, server.credential)
            except UnusableServer as error:
                unusable.append(str(error))
                continue
            if isinstance(read, StunServer):
                stun.setdefault((read.host, read.port), read)
            else:
                turn.setdefault((read.host, read.port, read.transport), read)
    return Servers(tuple(stun.values())[:SERVERS_LIMIT], tuple(turn.values())[:SERVERS_LIMIT], tuple(unusable))
