"""The addresses of this machine that media may use."""

import ipaddress
import itertools
import logging
from collections.abc import Iterator, Sequence
from functools import cache
from typing import Final

import ifaddr

ADDRESSES_LIMIT: Final = 10
"""Addresses of this machine that one peer connection uses, with a socket each; with as many of the other end they make
the 100 candidate pairs of RFC 8445 section 6.1.2.5."""

_log = logging.getLogger(__name__)


class NoInterface(ValueError):
    """There is no interface of that name, or no address to use. The text says which there are."""


def host_addresses(interfaces: Sequence[str] = ()) -> list[str]:
    """The addresses of the `interfaces`, which are names or addresses; of all but loopback if there are none given.

    Loopback is used where there is nothing else. Link-local IPv6 addresses are left out: they mean nothing without
    their interface.

    Raises:
        NoInterface: one of them is not there.
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
            raise NoInterface(f"no interface has the name or the address {wanted}; there are: {known}")
        chosen += [address for address in found if address not in chosen]
    return chosen


def media_addresses(interfaces: Sequence[str] = ()) -> list[str]:
    """As `host_addresses`, but `ADDRESSES_LIMIT` at most: of every interface some, in turn.

    Raises:
        NoInterface: one of them is not there.
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
    _tell(len(addresses), ", ".join(chosen))
    return chosen


@cache
def _tell(number: int, chosen: str) -> None:
    """Log what was chosen of how many, once."""
    _log.warning("of %d addresses media uses %d: %s; --interface chooses others", number, ADDRESSES_LIMIT, chosen)


def _present() -> Iterator[tuple[str, str]]:
    """Every interface with each of its addresses."""
    for adapter in ifaddr.get_adapters():
        for ip in adapter.ips:
            if isinstance(ip.ip, str):
                yield adapter.nice_name, ip.ip
            elif ip.ip[2] == 0 and not ipaddress.ip_address(ip.ip[0]).is_link_local:
                yield adapter.nice_name, ip.ip[0]
