"""The address of a robot, and why it cannot be reached. Pure."""

from dataclasses import dataclass
from typing import Final

from openrois_robots.adapter import address

__all__ = ["PORT", "Address", "read_address", "unreachable"]

PORT: Final = 26400
"""The port of the Kachaka API."""

_REMEDY: Final = "check --robot, and that the Kachaka API is switched on in the robot's app"
_REASONS: Final = (
    ("Connection refused", "nothing listens at this port"),
    ("DNS resolution failed", "this name is not known in the network"),
    ("Domain name not found", "this name is not known in the network"),
    ("No route to host", "there is no way to it in the network"),
    ("Network is unreachable", "there is no way to it in the network"),
    ("imed out", "it does not answer"),
    ("imeout", "it does not answer"),
    ("Socket closed", "it has closed the connection"),
    ("Connection reset", "it has closed the connection"),
    ("onnection closed", "what listens there is no Kachaka API"),
    ("HTTP2", "what listens there is no Kachaka API"),
    ("settings frame", "what listens there is no Kachaka API"),
)
"""By a part of what gRPC says: what it means."""


@dataclass(frozen=True, slots=True)
class Address(address.Address):
    """The address of a Kachaka."""

    port: int = PORT

    @property
    def target(self) -> str:
        """The address for gRPC, which looks a name up itself, beside the event loop."""
        return f"dns:///{self.text}"


def read_address(text: str) -> Address:
    """Read `HOST` or `HOST:PORT`; an IPv6 address with a port stands in brackets.

    Raises:
        ValueError: it is none; a sentence for a person.
    """
    return Address(*address.read_host_and_port(text, PORT, "192.168.1.20 or kachaka.local:26400"))


def unreachable(details: str) -> str:
    """Return why a robot cannot be reached and what to do, from what gRPC says."""
    reason = next((why for part, why in _REASONS if part in details), details.strip() or "it does not answer")
    return f"{reason}; {_REMEDY}"
