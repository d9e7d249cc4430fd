"""The framing of messages between a child process and its parent over pipes. Pure.

Each message is two little-endian u32, the lengths of a JSON object and of the sound behind it, then both. The parent
sends requests, the child answers each with one message, or with several of which the last says so.
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
    """The lengths of body and sound, as a header says."""

    body: int
    sound: int


def encode(body: dict[str, Any], sound: bytes = b"") -> bytes:
    """Return a message as bytes."""
    text = json.dumps(body, separators=(",", ":")).encode()
    return HEADER.pack(len(text), len(sound)) + text + sound


def decode_header(header: bytes) -> Lengths:
    """Read a header.

    Raises:
        FramingError: a length is over its limit.
    """
    lengths = Lengths(*HEADER.unpack(header))
    if lengths.body > MAX_BODY or lengths.sound > MAX_SOUND:
        raise FramingError(
            f"a message of {lengths.body} and {lengths.sound} bytes is over the limits of {MAX_BODY} and {MAX_SOUND}"
        )
    return lengths


def decode_body(text: bytes) -> dict[str, Any]:
    """Read the JSON object of a message.

    Raises:
        FramingError: the body is no JSON object.
    """
    try:
        body = json.loads(text)
    except ValueError as error:
        raise FramingError("the body of a message is not JSON") from error
    if not isinstance(body, dict):
        raise FramingError("the body of a message is not a JSON object")
    return body
