"""Addresses of the engine link, `unix:/path` or `tcp:host:port`, and the environment variables that hold them."""

from __future__ import annotations

import socket
from dataclasses import dataclass
from typing import Final, TypeAlias

from openrois_avatar.link.messages import LinkError

ADDRESS_VARIABLE: Final = "OPENROIS_LINK_ADDRESS"
SECRET_VARIABLE: Final = "OPENROIS_LINK_SECRET"  # noqa: S105 - the variable's name


@dataclass(frozen=True, slots=True)
class UnixAddress:
    """A socket in the file system."""

    path: str

    def __str__(self) -> str:
        return f"unix:{self.path}"


@dataclass(frozen=True, slots=True)
class TcpAddress:
    """A host name or IP address (IPv6 in brackets) and a port."""

    host: str
    port: int

    def __str__(self) -> str:
        return f"tcp:[{self.host}]:{self.port}" if ":" in self.host else f"tcp:{self.host}:{self.port}"


Address: TypeAlias = UnixAddress | TcpAddress


def parse_address(text: str) -> Address:
    """Read an address.

    Raises:
        LinkError: it has neither form.
    """
    carrier, _, rest = text.partition(":")
    if carrier == "unix" and rest:
        return UnixAddress(rest)
    host, _, port = rest.rpartition(":")
    if carrier == "tcp" and host and port.isascii() and port.isdigit() and int(port[:6]) < 65_536:
        return TcpAddress(host.removeprefix("[").removesuffix("]"), int(port))
    raise LinkError(f"address: expected unix:/path or tcp:host:port, not {text[:100]!r}")


def connect_socket(address: Address, timeout: float) -> socket.socket:
    """Return a connected blocking socket; every later operation on it is bounded by `timeout` seconds as well.

    Raises:
        LinkError: the connection failed; the text has address and reason.
    """
    try:
        if isinstance(address, TcpAddress):
            stream = socket.create_connection((address.host, address.port), timeout)
            stream.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            return stream
        stream = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
    except OSError as error:
        raise _unreachable(address, error) from error
    try:
        stream.settimeout(timeout)
        stream.connect(address.path)
    except OSError as error:
        stream.close()
        raise _unreachable(address, error) from error
    return stream


def _unreachable(address: Address, error: OSError) -> LinkError:
    return LinkError(f"cannot connect to {address}: {error}; check that the adapter runs, and its --link")
