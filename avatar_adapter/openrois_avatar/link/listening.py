"""A socket that listens for engines, on this machine alone; it is removed with its context, or its process."""

from __future__ import annotations

import socket
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Final

from openrois.auth.loopback import is_loopback
from openrois_avatar.link.address import Address, TcpAddress, UnixAddress, parse_address
from openrois_avatar.link.messages import LinkError
from openrois_avatar.link.private_path import clear, private_path

BACKLOG: Final = 8


@contextmanager
def listening(address: str | None = None) -> Iterator[tuple[socket.socket, str]]:
    """Listen for as long as the context lasts; yield a non-blocking socket, and its address.

    Args:
        address: `unix:/path` or `tcp:host:port` on a loopback address (port 0: a free one); without it a Unix socket in
            a directory of its own that only this user may enter.

    Raises:
        LinkError: the address is malformed, not of this machine alone, or cannot be listened on.
    """
    with private_path() as private:
        place = parse_address(address or f"unix:{private}")
        with _listen(place) as listener:
            try:
                yield listener, _address_of(place, listener)
            finally:
                if isinstance(place, UnixAddress):
                    Path(place.path).unlink(missing_ok=True)


def _listen(place: Address) -> socket.socket:
    family = socket.AF_UNIX
    name: str | tuple[str, int]
    if isinstance(place, UnixAddress):
        name = place.path
        clear(place.path)
    else:
        name = place.host, place.port
        family = socket.AF_INET6 if ":" in place.host else socket.AF_INET
        _check_loopback(place.host)
    listener = socket.socket(family, socket.SOCK_STREAM)
    try:
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listener.bind(name)
        if isinstance(place, UnixAddress):
            # No client can connect before it listens.
            Path(place.path).chmod(0o600)
        listener.listen(BACKLOG)
        listener.setblocking(False)
    except OSError as error:
        listener.close()
        raise LinkError(f"cannot listen on {place}: {error}; free it, or choose another address") from error
    return listener


def _address_of(place: Address, listener: socket.socket) -> str:
    """Return the address of `listener`, with the port that the system chose."""
    if isinstance(place, UnixAddress):
        return str(place)
    return str(TcpAddress(place.host, listener.getsockname()[1]))


def _check_loopback(host: str) -> None:
    if not is_loopback(host):
        raise LinkError(f"the engine link stays on this machine, and {host} is no loopback address; use 127.0.0.1")
