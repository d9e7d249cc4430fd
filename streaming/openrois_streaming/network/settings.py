"""Network settings of peer connections. Pure.

All of them raise ValueError with a sentence that names the wrong value and what is allowed.
"""

import ipaddress
from dataclasses import dataclass, field
from typing import Final, NamedTuple, Self

from openrois_streaming.network.admission import AdmissionSettings
from openrois_streaming.network.policy import PORTS_FROM, CandidatePolicy
from openrois_streaming.network.session_limits import SessionLimits

PROFILES: Final = {
    "lan": CandidatePolicy(),
    "public": CandidatePolicy(allow_loopback=False, allow_private=False),
}
"""Profiles of candidates: `lan` permits addresses of this machine, of private networks and of the internet; `public`
those of the internet alone, in both directions."""


class PortRange(NamedTuple):
    """Range of UDP ports, both ends included."""

    first: int
    last: int

    @classmethod
    def parse(cls, text: str) -> Self:
        """Read `50000-50100`, or a single port."""
        first, dash, last = text.partition("-")
        ends = (first, last if dash else first)
        if not all(end.isascii() and end.isdigit() and len(end) <= 5 for end in ends):
            raise ValueError(f"{text[:40]!r} is not a range of UDP ports, such as 50000-50100")
        return cls(int(ends[0]), int(ends[1]))


@dataclass(frozen=True, slots=True)
class NetworkSettings:
    """Network settings of an engine's peer connections.

    Attributes:
        interfaces: names (`eth0`) or addresses of the interfaces that media passes through; all but loopback if empty.
        ports: the UDP ports that may be opened, a few for each viewer; any free ones if None.
        public_address: the IPv4 address under which a 1:1 NAT (a router that forwards the UDP ports unchanged, or a
            cloud machine's public address) makes this machine reachable; None without one.
        relay_only: media passes over TURN servers alone; candidates name no address of this machine.
        candidates: a key of `PROFILES`.
        admission: limits on what is received.
        sessions: limits on the applications that stream at a time.
    """

    interfaces: tuple[str, ...] = ()
    ports: PortRange | None = None
    public_address: str | None = None
    relay_only: bool = False
    candidates: str = "lan"
    admission: AdmissionSettings = field(default_factory=AdmissionSettings)
    sessions: SessionLimits = field(default_factory=SessionLimits)

    def __post_init__(self) -> None:
        if self.candidates not in PROFILES:
            raise ValueError(f"{self.candidates!r} is not a profile of candidates; use one of {', '.join(PROFILES)}")
        for name in self.interfaces:
            if not name or len(name) > 64 or not name.isprintable():
                raise ValueError(f"{name[:40]!r} is not the name or address of an interface")
        if self.ports is not None and not PORTS_FROM <= self.ports.first <= self.ports.last < 2**16:
            raise ValueError(
                f"{self.ports.first}-{self.ports.last} is not a range of UDP ports: "
                f"from {PORTS_FROM} to 65535, the smaller one first"
            )
        if self.public_address is not None:
            _check_public(self.public_address)
        if self.relay_only and (self.public_address is not None or self.ports is not None or self.interfaces):
            raise ValueError("--relay-only excludes --interface, --udp-ports and --public-address: leave them out")

    @property
    def policy(self) -> CandidatePolicy:
        """Policy on the addresses that may be sent to."""
        return PROFILES[self.candidates]


def _check_public(text: str) -> None:
    try:
        address = ipaddress.IPv4Address(text)
    except ValueError:
        raise ValueError(f"the public address {text[:64]!r} is not an IPv4 address") from None
    if address.is_multicast or address.is_unspecified or address.is_loopback or address.is_reserved:
        raise ValueError(f"{text} cannot be reached from other machines: give the public IPv4 address of this one")
