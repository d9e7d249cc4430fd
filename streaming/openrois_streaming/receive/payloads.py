"""Depacketizers of H.264 (RFC 6184) and VP8 (RFC 7741). Pure."""

from collections.abc import Callable
from typing import NamedTuple

_START_CODE = b"\x00\x00\x00\x01"
_IDR, _SEQUENCE_PARAMETERS = 5, 7
_STAP_A, _FU_A = 24, 28


class MalformedPayload(ValueError):
    """Payload that violates its format. The text says what is wrong and quotes nothing of it."""


class Piece(NamedTuple):
    """Part of an encoded picture in one RTP packet.

    `data` is for the decoder, all pieces of a picture concatenated. `begins`: a picture may begin with this piece.
    `key`: the picture is a key frame; if unset, another piece may set it. `opens_key`: a key frame certainly begins
    here.
    """

    data: bytes
    begins: bool
    key: bool
    opens_key: bool


Depacketizer = Callable[[bytes], Piece]


def vp8_piece(payload: bytes) -> Piece:
    """Return the part of a VP8 frame in a payload (RFC 7741 sections 4.2 and 4.3).

    Raises:
        MalformedPayload: the descriptor is longer than the payload, or no data follows it.
    """
    if not payload:
        raise MalformedPayload("an empty VP8 payload")
    first = payload[0]
    position = 1 + (_vp8_extension(payload) if first & 0x80 else 0)
    if len(payload) <= position:
        raise MalformedPayload("a VP8 payload without data")
    begins = first & 0x1F == 0x10
    key = begins and not payload[position] & 1
    return Piece(payload[position:], begins, key, key)


def _vp8_extension(payload: bytes) -> int:
    """Return the length of the extended control bits and of the fields they announce."""
    if len(payload) < 3:
        raise MalformedPayload("a truncated VP8 descriptor")
    bits = payload[1]
    length = 1
    if bits & 0x80:
        length += 2 if payload[2] & 0x80 else 1
    if bits & 0x40:
        length += 1
    if bits & 0x30:
        length += 1
    return length


def h264_piece(payload: bytes) -> Piece:
    """Return the part of an access unit (Annex B) in a payload: a NAL unit, STAP-A or FU-A (RFC 6184 section 5.6).

    Raises:
        MalformedPayload: it is truncated, or of another kind.
    """
    if len(payload) < 2:
        raise MalformedPayload("a truncated H.264 payload")
    kind = payload[0] & 0x1F
    if kind == _FU_A:
        return _fragment(payload)
    if kind == _STAP_A:
        return _aggregate(payload)
    if not 1 <= kind < _STAP_A:
        raise MalformedPayload(f"an H.264 payload of kind {kind}")
    return Piece(_START_CODE + payload, _begins(kind, payload[1]), kind == _IDR, kind == _SEQUENCE_PARAMETERS)


def _begins(kind: int, first: int) -> bool:
    """Tell whether a NAL unit begins a picture; `first` is its first byte after the header.

    A slice does if it begins with macroblock 0, which is the single bit 1 there (ITU-T H.264 section 7.3.3).
    """
    return kind > _IDR or bool(first & 0x80)


def _fragment(payload: bytes) -> Piece:
    if len(payload) < 3:
        raise MalformedPayload("an H.264 fragment without data")
    header = payload[1]
    kind = header & 0x1F
    if not header & 0x80:
        return Piece(payload[2:], False, kind == _IDR, False)
    data = b"".join((_START_CODE, bytes([payload[0] & 0xE0 | kind]), payload[2:]))
    return Piece(data, _begins(kind, payload[2]), kind == _IDR, kind == _SEQUENCE_PARAMETERS)


def _aggregate(payload: bytes) -> Piece:
    units: list[bytes] = []
    position = 1
    while position < len(payload):
        end = position + 2 + int.from_bytes(payload[position : position + 2], "big")
        unit = payload[position + 2 : end]
        if end > len(payload) or not unit:
            raise MalformedPayload("a truncated H.264 aggregate")
        units.append(unit)
        position = end
    kinds = {unit[0] & 0x1F for unit in units}
    begins = _begins(units[0][0] & 0x1F, units[0][1] if len(units[0]) > 1 else 0)
    return Piece(b"".join(_START_CODE + unit for unit in units), begins, _IDR in kinds, _SEQUENCE_PARAMETERS in kinds)
