"""The address of a robot, and why it cannot be reached. Pure."""

import re
from dataclasses import dataclass
from typing import Final

__all__ = ["PORT", "Address", "read_address", "unreachable"]

PORT: Final = 26400
"""The port of the Kachaka API."""

_HOST: Final = re.compile(r"[A-Za-z0-9]([A-Za-z0-9._-]*[A-Za-z0-9])?|[0-9A-Fa-f:.]*:[0-9A-Fa-f:.%A-Za-z0-9]*")
_EXPECTED: Final = "expected HOST or HOST:PORT, such as 192.168.1.20 or kachaka.local:26400"
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
class Address:
    """The address of a robot.

    Attributes:
        host: name or address.
        port: of its API.
    """

    host: str
    port: int = PORT

    @property
    def text(self) -> str:
        """The address as a person writes it."""
        return f"[{self.host}]:{self.port}" if ":" in self.host else f"{self.host}:{self.port}"

    @property
    def target(self) -> str:
        """The address for gRPC, which looks a name up itself, beside the event loop."""
        return f"dns:///{self.text}"


def read_address(text: str) -> Address:
    """Read `HOST` or `HOST:PORT`; an IPv6 address with a port stands in brackets.

    Raises:
        ValueError: it is none; a sentence for a person.
    """
    host, port = _split(text.strip())
    if not _HOST.fullmatch(host):
        raise ValueError(f"--robot: {text!r} is no address of a robot: {_EXPECTED}")
    if not port.isascii() or not port.isdigit() or not 1 <= int(port) <= 65535:
        raise ValueError(f"--robot: {port!r} in {text!r} is no port: {_EXPECTED}")
    return Address(host, int(port))


def unreachable(details: str) -> str:
    """Return why a robot cannot be reached and what to do, from what gRPC says."""
    reason = next((why for part, why in _REASONS if part in details), details.strip() or "it does not answer")
    return f"{reason}; {_REMEDY}"


def _split(text: str) -> tuple[str, str]:
    if text.startswith("["):
        host, _, rest = text[1:].partition("]")
        return host, rest[1:] if rest.startswith(":") else (rest or str(PORT))
    if text.count(":") > 1:
        return text, str(PORT)
    host, colon, port = text.partition(":")
    return host, port if colon else str(PORT)
