"""The address of a daemon. Pure."""

from dataclasses import dataclass
from typing import Final

from openrois_robots.adapter import address

__all__ = ["PORT", "REMEDY", "Address", "read_address"]

PORT: Final = 8000
"""The port of the daemon."""

REMEDY: Final = (
    "check --robot, and that the robot's daemon runs and listens to the network, not to its own machine alone"
    " (--fastapi-host 0.0.0.0)"
)


@dataclass(frozen=True, slots=True)
class Address(address.Address):
    """The address of a daemon."""

    port: int = PORT

    def url(self, scheme: str) -> str:
        """Return the address as a URL without a path."""
        return f"{scheme}://{self.text}"


def read_address(text: str) -> Address:
    """Read `HOST` or `HOST:PORT`; an IPv6 address with a port stands in brackets.

    Raises:
        ValueError: it is none; a sentence for a person.
    """
    return Address(*address.read_host_and_port(text, PORT, "192.168.1.20 or reachy-mini.local:8000"))
