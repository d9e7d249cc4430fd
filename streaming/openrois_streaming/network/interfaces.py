"""The addresses of this machine that media may use."""

import ipaddress
from collections.abc import Iterator, Sequence

import ifaddr


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


def _present() -> Iterator[tuple[str, str]]:
    """Every interface with each of its addresses."""
    for adapter in ifaddr.get_adapters():
        for ip in adapter.ips:
            if isinstance(ip.ip, str):
                yield adapter.nice_name, ip.ip
            elif ip.ip[2] == 0 and not ipaddress.ip_address(ip.ip[0]).is_link_local:
                yield adapter.nice_name, ip.ip[0]
