"""Payload formats of RTP: a frame of H.264 (RFC 6184), VP8 (RFC 7741) or Opus (RFC 7587) as payloads. Pure."""

from collections.abc import Iterator, Sequence

PAYLOAD_LIMIT = 1172
"""Limit on the bytes of a payload, so that every packet passes where IPv6 does (1,280 bytes, RFC 8200 section 5): with
48 bytes of IPv6 and UDP, 4 of a TURN channel, 12 of the RTP header, 24 of its extensions, 2 of RTX and 16 of SRTP it is
1,278."""


def payloads_of(mime_type: str, data: bytes) -> tuple[bytes, ...]:
    """Return the RTP payloads of a frame of `video/H264` or `video/VP8`, or a block of `audio/opus` (RFC 7587).

    Raises:
        ValueError: the media type has no payload format here.
    """
    match mime_type:
        case "video/H264":
            return h264_payloads(data, PAYLOAD_LIMIT)
        case "video/VP8":
            return vp8_payloads(data, PAYLOAD_LIMIT)
        case "audio/opus":
            return (data,)
    raise ValueError(f"{mime_type} has no payload format here")


_START_CODE = b"\0\0\1"
_STAP_A, _FU_A = 24, 28
_TYPE, _IMPORTANCE = 0x1F, 0x60  # the lower and the middle bits of a NAL unit's first byte (section 1.3)
_FIRST, _LAST = 0x80, 0x40  # of a FU header (section 5.8)


def h264_payloads(access_unit: bytes, limit: int) -> tuple[bytes, ...]:
    """Return the RTP payloads of an access unit in Annex B form, none longer than `limit` bytes.

    All fragments of a NAL unit but the last are `limit` bytes long: datagrams of one length can leave together.
    """
    payloads: list[bytes] = []
    small: list[bytes] = []
    room = limit - 1
    for unit in _nal_units(access_unit):
        needed = 2 + len(unit)
        if small and needed > room:
            payloads.append(_together(small))
            small, room = [], limit - 1
        if len(unit) > limit:
            payloads += _fragments(unit, limit)
        else:
            small.append(unit)
            room -= needed
    if small:
        payloads.append(_together(small))
    return tuple(payloads)


def _nal_units(access_unit: bytes) -> Iterator[bytes]:
    """Yield the NAL units between start codes (ISO/IEC 14496-10 annex B); none ends with a zero byte."""
    start = access_unit.find(_START_CODE)
    while start >= 0:
        end = access_unit.find(_START_CODE, start + 3)
        unit = access_unit[start + 3 : end if end >= 0 else None].rstrip(b"\0")
        if unit:
            yield unit
        start = end


def _together(units: Sequence[bytes]) -> bytes:
    """Return one unit unchanged, or several as a STAP-A with the importance of the most important one (section 5.7)."""
    if len(units) == 1:
        return units[0]
    header = _STAP_A | max(unit[0] & _IMPORTANCE for unit in units)
    return bytes((header,)) + b"".join(len(unit).to_bytes(2, "big") + unit for unit in units)


def _fragments(unit: bytes, limit: int) -> Iterator[bytes]:
    indicator, kind = unit[0] & ~_TYPE | _FU_A, unit[0] & _TYPE
    step = limit - 2
    position = 1
    while position < len(unit):
        end = position + step
        flags = (_FIRST if position == 1 else 0) | (_LAST if end >= len(unit) else 0)
        yield bytes((indicator, flags | kind)) + unit[position:end]
        position = end


_START = b"\x10"  # S: the first piece of the first partition (section 4.2)
_FURTHER = b"\x00"


def vp8_payloads(frame: bytes, limit: int) -> tuple[bytes, ...]:
    """Return the RTP payloads of a frame, all but the last `limit` bytes long.

    They carry no picture id: a viewer that skips some pictures, or changes to another encoding, gets sequence numbers
    without gaps, and a picture id would show a loss.
    """
    step = limit - 1
    return tuple(
        (_FURTHER if position else _START) + frame[position : position + step]
        for position in range(0, len(frame), step)
    )
