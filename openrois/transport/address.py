"""Addresses of gateways as people give them: what a gateway prints, `http://host:port/`, works everywhere."""

from collections.abc import Sequence
from typing import Final
from urllib.parse import urlsplit

from websockets.exceptions import InvalidURI
from websockets.uri import parse_uri

__all__ = ["adapter_url", "adapter_urls", "gateway_url"]

_SCHEMES: Final = {"http": "ws", "https": "wss", "ws": "ws", "wss": "wss"}


def gateway_url(url: str, path: str = "/") -> str:
    """Return the WebSocket address of a gateway.

    Args:
        url: `ws://`, `wss://`, `http://` or `https://`, a host, and what else there is to it.
        path: stands where `url` has none.

    Raises:
        ValueError: it is no address, or carries a password.
    """
    problem = f"{url!r} is no address of a gateway, such as ws://127.0.0.1:8765{path}"
    try:
        parts = urlsplit(url)
        scheme = _SCHEMES[parts.scheme]
        named = path if parts.path in ("", "/") else parts.path
        address = parts._replace(scheme=scheme, path=named, fragment="").geturl()
        parse_uri(address)
    except (KeyError, ValueError, InvalidURI):
        # A port beyond all ports is a ValueError.
        raise ValueError(problem) from None
    if parts.username is not None:
        raise ValueError("credentials do not belong in an address, where logs would keep them: give a token")
    return address


def adapter_url(url: str) -> str:
    """Return the address at which a gateway takes adapters: `/adapter`, unless the address names another path.

    Applications connect to any path but that, so that an adapter at `/` would be taken for one and never be asked.

    Raises:
        ValueError: it is no address, or carries a password.
    """
    return gateway_url(url, "/adapter")


def adapter_urls(addresses: str | Sequence[str]) -> tuple[str, ...]:
    """Return the addresses at which several gateways take adapters, each as `adapter_url` does.

    Args:
        addresses: of the gateways, as a sequence, or as a text with commas between them.

    Raises:
        ValueError: one of them is no address, or carries a password; or there is none.
    """
    named = addresses.split(",") if isinstance(addresses, str) else addresses
    urls = tuple(adapter_url(address.strip()) for address in named)
    if not urls:
        raise ValueError("there is no gateway: name at least one, such as ws://127.0.0.1:8765/adapter")
    return urls
