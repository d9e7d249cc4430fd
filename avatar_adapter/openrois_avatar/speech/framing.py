"""How the speech process and its parent talk through pipes; pure.

Each message is two little-endian u32, the lengths of a JSON object and of the sound behind it, then both. The parent
sends requests without sound, the child answers each with one message.
"""

from __future__ import annotations

import json
import struct
from typing import Any, Final, NamedTuple

HEADER: Final = struct.Struct("<II")
MAX_BODY: Final = 4 * 1024 * 1024
MAX_SOUND: Final = 64 * 1024 * 1024


class FramingError(Exception):
    """The other side does not speak this protocol."""


class Lengths(NamedTuple):
    """What follows a header."""

    body: int
    sound: int


def encode(body: dict[str, Any], sound: bytes = b"") -> bytes:
    """One message."""
    text = json.dumps(body, separators=(",", ":")).encode()
    return HEADER.pack(len(text), len(sound)) + text + sound


def decode_header(header: bytes) -> Lengths:
    """The lengths of what follows.

    Raises:
        FramingError: they are over the limits.
    """
    lengths = Lengths(*HEADER.unpack(header))
    if lengths.body > MAX_BODY or lengths.sound > MAX_SOUND:
        raise FramingError(f"a message of {lengths.body} and {lengths.sound} bytes")
    return lengths


def decode_body(text: bytes) -> dict[str, Any]:
    """The JSON object of a message.

    Raises:
        FramingError: it is none.
    """
    try:
        body = json.loads(text)
    except ValueError as error:
        raise FramingError("a message that is not JSON") from error
    if not isinstance(body, dict):
        raise FramingError("a message that is not a JSON object")
    return body
