"""Policy on the addresses that media may be sent to, in any spelling. Pure.

An application's candidates tell this process where to send packets (RFC 8445 section 5.1.1). The deployment decides
here which addresses they may name.
"""

import ipaddress
from dataclasses import dataclass
from typing import Final, TypeAlias

PORTS_FROM: Final = 1024
"""Ports below belong to services of the system; no ICE agent receives there."""

Address: TypeAlias = ipaddress.IPv4Address | ipaddress.IPv6Address

_NOWHERE: Final = ipaddress.ip_network("0.0.0.0/8")  # "this network" (RFC 6890): Linux takes 0.0.0.0 for itself
_COMPATIBLE: Final = ipaddress.ip_network("::/96")  # IPv4-compatible, deprecated (RFC 4291 section 2.5.5.1)
_SITE_LOCAL: Final = ipaddress.ip_network("fec0::/10")  # deprecated (RFC 3879)
_SIX_TO_FOUR: Final = ipaddress.ip_network("2002::/16")  # RFC 3056; newer Pythons do not call it global
_TRANSLATED: Final = ipaddress.ip_network("64:ff9b::/96")  # NAT64 (RFC 6052)


@dataclass(frozen=True, slots=True)
class CandidatePolicy:
    """Policy on the viewers' addresses that a deployment sends to.

    Never used: multicast, unspecified, reserved and broadcast addresses, and those that RFC 8445 section 5.1.1.1
    excludes. An address that embeds another one (6to4, Teredo, NAT64) is permitted only if both are.
    `allow_private` covers the private networks of RFC 1918 and RFC 4193, and shared address space (RFC 6598).
    """

    allow_loopback: bool = True
    allow_private: bool = True
    allow_link_local: bool = False

    def permits(self, host: str) -> bool:
        """Tell whether `host` is a literal IP address that may be used; names, as `.local`, are never resolved."""
        try:
            address = ipaddress.ip_address(host)
        except ValueError:
            return False
        if isinstance(address, ipaddress.IPv4Address):
            return self._permits(address)
        if address.scope_id is not None or address.ipv4_mapped is not None or address in _SITE_LOCAL:
            return False
        if address in _COMPATIBLE and not address.is_loopback:
            return False
        return self._permits(address) and all(self._permits(inner) for inner in _carried(address))

    def permits_target(self, host: str, port: int) -> bool:
        """Tell whether media may be sent to this address and port."""
        return PORTS_FROM <= port < 2**16 and self.permits(host)

    def _permits(self, address: Address) -> bool:
        if address.is_multicast or address.is_unspecified:
            return False
        if address.is_loopback:
            return self.allow_loopback
        if address.is_link_local:
            return self.allow_link_local
        if address.version == 4 and (address in _NOWHERE or address.is_reserved):
            return False
        # Of 6to4 the address that it carries decides.
        return self.allow_private or address.is_global or address in _SIX_TO_FOUR


def _carried(address: ipaddress.IPv6Address) -> list[ipaddress.IPv4Address]:
    """Return the IPv4 addresses that packets to `address` may end up at."""
    carried = [inner for inner in (address.sixtofour, *(address.teredo or ())) if inner is not None]
    if address in _TRANSLATED:
        carried.append(ipaddress.IPv4Address(int(address) & 0xFFFFFFFF))
    return carried
