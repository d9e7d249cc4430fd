"""What a datagram on a media port is, by its first bytes (RFC 7983 section 7). Pure."""

from enum import IntEnum
from typing import Final

STUN_LIMIT: Final = 1500
"""Bytes of a STUN message that are read; connectivity checks have about 100 (RFC 8489 section 6.1 bounds them)."""

_HEADER: Final = 20
_COOKIE: Final = b"\x21\x12\xa4\x42"


class Kind(IntEnum):
    """What a datagram claims to be."""

    STUN = 0
    DTLS = 1
    MEDIA = 2
    """SRTP or SRTCP."""
    OTHER = 3
    """ZRTP, TURN channels, and what no protocol claims."""


def _kind(first: int) -> Kind:
    if first < 4:
        return Kind.STUN
    if 20 <= first < 64:
        return Kind.DTLS
    if 128 <= first < 192:
        return Kind.MEDIA
    return Kind.OTHER


KINDS: Final = tuple(_kind(first) for first in range(256))
"""The kind of a datagram by its first byte."""


class StunClass(IntEnum):
    """The class of a STUN message (RFC 8489 section 5)."""

    REQUEST = 0x000
    INDICATION = 0x010
    SUCCESS = 0x100
    ERROR = 0x110


def stun_class(datagram: bytes) -> StunClass | None:
    """The class of a STUN message; None if its header is not one of RFC 8489, or it is too long."""
    size = len(datagram)
    if not _HEADER <= size <= STUN_LIMIT or size % 4 or datagram[4:8] != _COOKIE:
        return None
    if int.from_bytes(datagram[2:4], "big") != size - _HEADER:
        return None
    return StunClass(int.from_bytes(datagram[0:2], "big") & 0x110)


def transaction_of(datagram: bytes) -> bytes:
    """The transaction id of a STUN message (RFC 8489 section 5)."""
    return datagram[8:_HEADER]
