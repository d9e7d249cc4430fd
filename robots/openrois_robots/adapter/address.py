"""The address of a robot in the network. Pure."""

import re
from dataclasses import dataclass
from typing import Final

__all__ = ["Address", "read_host_and_port"]

_HOST: Final = re.compile(r"[A-Za-z0-9]([A-Za-z0-9._-]*[A-Za-z0-9])?|[0-9A-Fa-f:.]*:[0-9A-Fa-f:.%A-Za-z0-9]*")


@dataclass(frozen=True, slots=True)
class Address:
    """The address of a robot.

    Attributes:
        host: name or address.
        port: of its API.
    """

    host: str
    port: int

    @property
    def text(self) -> str:
        """The address as a person writes it."""
        return f"[{self.host}]:{self.port}" if ":" in self.host else f"{self.host}:{self.port}"


def read_host_and_port(text: str, port: int, example: str) -> tuple[str, int]:
    """Read `HOST` or `HOST:PORT`; an IPv6 address with a port stands in brackets.

    Args:
        text: of the option `--robot`.
        port: where none is given.
        example: of an address, for the error: `192.168.1.20 or kachaka.local:26400`.

    Raises:
        ValueError: it is none; a sentence for a person.
    """
    expected = f"expected HOST or HOST:PORT, such as {example}"
    host, number = _split(text.strip(), str(port))
    if not _HOST.fullmatch(host):
        raise ValueError(f"--robot: {text!r} is no address of a robot: {expected}")
    if not number.isascii() or not number.isdigit() or not 1 <= int(number) <= 65535:
        raise ValueError(f"--robot: {number!r} in {text!r} is no port: {expected}")
    return host, int(number)


def _split(text: str, port: str) -> tuple[str, str]:
    if text.startswith("["):
        host, _, rest = text[1:].partition("]")
        return host, rest[1:] if rest.startswith(":") else (rest or port)
    if text.count(":") > 1:
        return text, port
    host, colon, number = text.partition(":")
    return host, number if colon else port
