"""Subjects of NATS that gateways use among themselves, without any text that stands for more than itself. Pure."""

import string
from typing import Final

__all__ = ["MAX_NAME", "Subjects", "escaped"]

MAX_NAME: Final = 128
"""Bytes of UTF-8 in a name: escaped three times as long, it still fits into a subject."""

_PLAIN: Final = frozenset((string.ascii_letters + string.digits + "-").encode())


def escaped(name: str) -> str:
    """Return a name as one token of a subject: letters, digits and `-` as they are, other bytes as `_` and two digits.

    Two names never have the same token.

    Raises:
        ValueError: the name is empty or too long, or no text.
    """
    data = name.encode()
    if not 0 < len(data) <= MAX_NAME:
        raise ValueError(f"a name of 1 to {MAX_NAME} bytes is needed, not one of {len(data)}")
    return "".join(chr(byte) if byte in _PLAIN else f"_{byte:02x}" for byte in data)


class Subjects:
    """The subjects below one prefix.

    Args:
        prefix: a name that all gateways of a cluster share, and no other program at the same NATS uses.
    """

    def __init__(self, prefix: str) -> None:
        self._prefix = escaped(prefix)
        self.beats = f"{self._prefix}.beat.*"
        """Signs of life of all gateways."""

    def beat(self, gateway_id: str) -> str:
        """Return where a gateway gives signs of life."""
        return f"{self._prefix}.beat.{escaped(gateway_id)}"

    def dial(self, gateway_id: str) -> str:
        """Return where a gateway is dialled."""
        return f"{self._prefix}.dial.{escaped(gateway_id)}"

    def streams(self, link: str) -> str:
        """Return where all frames to the streams of one connection of a gateway come."""
        return f"{self._prefix}.stream.{link}.*"

    def stream(self, link: str, number: int) -> str:
        """Return where the frames to one stream come."""
        return f"{self._prefix}.stream.{link}.{number}"
