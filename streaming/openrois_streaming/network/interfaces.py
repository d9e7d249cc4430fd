"""Addresses of this machine that media may use."""

import ipaddress
import itertools
import logging
from collections.abc import Iterator, Sequence
from functools import cache
from typing import Final

ADDRESSES_LIMIT: Final = 10
"""Addresses of this machine that one peer connection uses, with a socket each; with as many of the other end they make
the 100 candidate pairs of RFC 8445 section 6.1.2.5."""

_log = logging.getLogger(__name__)


class NoInterface(ValueError):
    """Interface name or address that this machine does not have. The text lists those it has."""


def host_addresses(interfaces: Sequence[str] = ()) -> list[str]:
    """Return the addresses of `interfaces`, given by name or address; all but loopback if none are given.

    Loopback is used where there is nothing else. Link-local IPv6 addresses are left out: they mean nothing without
    their interface.

    Raises:
        NoInterface: this machine lacks one of them.
    """
    present = list(_present())
    if not interfaces:
        others = [address for _, address in present if not ipaddress.ip_address(address).is_loopback]
        return others or [address for _, address in present if ipaddress.ip_address(address).version == 4]
    chosen: list[str] = []
    for wanted in interfaces:
        found = [address for name, address in present if wanted in (name, address)]
        if not found:
            known = ", ".join(sorted({name for name, _ in present})) or "none"
            raise NoInterface(f"no interface has the name or address {wanted}; use one of: {known}")
        chosen += [address for address in found if address not in chosen]
    return chosen


def media_addresses(interfaces: Sequence[str] = ()) -> list[str]:
    """Return as `host_addresses`, but `ADDRESSES_LIMIT` at most, in turn from each interface.

    Raises:
        NoInterface: this machine lacks one of them.
    """
    addresses = host_addresses(interfaces)
    if len(addresses) <= ADDRESSES_LIMIT:
        return addresses
    grouped: dict[str, list[str]] = {}
    for name, address in _present():
        if address in addresses:
            grouped.setdefault(name, []).append(address)
    in_turn = (each for rank in itertools.zip_longest(*grouped.values()) for each in rank if each is not None)
    chosen = list(itertools.islice(dict.fromkeys(in_turn), ADDRESSES_LIMIT))
    _log_choice(len(addresses), ", ".join(chosen))
    return chosen


@cache
def _log_choice(number: int, chosen: str) -> None:
    """Log once which addresses were chosen."""
    _log.warning("of %d addresses media uses %d: %s; --interface chooses others", number, ADDRESSES_LIMIT, chosen)


def _present() -> Iterator[tuple[str, str]]:
    """Yield every interface with each of its addresses."""
    # The options of the network are also shown, and read, where the libraries of the media plane are not installed.
    import ifaddr

    for adapter in ifaddr.get_adapters():
        for ip in adapter.ips:
            if isinstance(ip.ip, str):
                yield adapter.nice_name, ip.ip
            elif ip.ip[2] == 0 and not ipaddress.ip_address(ip.ip[0]).is_link_local:
                yield adapter.nice_name, ip.ip[0]
