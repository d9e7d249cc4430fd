"""H.264 in RTP (RFC 6184, packetization-mode 1): an access unit becomes single NAL units, STAP-As and FU-As. Pure."""

from collections.abc import Iterator, Sequence

_START_CODE = b"\0\0\1"
_STAP_A, _FU_A = 24, 28
_TYPE, _IMPORTANCE = 0x1F, 0x60  # the lower and the middle bits of a NAL unit's first byte (section 1.3)
_FIRST, _LAST = 0x80, 0x40  # of a FU header (section 5.8)


def h264_payloads(access_unit: bytes, limit: int) -> tuple[bytes, ...]:
    """The RTP payloads of an access unit in Annex B form, none longer than `limit` bytes.

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
    """The NAL units between start codes (ISO/IEC 14496-10 annex B); none ends with a zero byte."""
    start = access_unit.find(_START_CODE)
    while start >= 0:
        end = access_unit.find(_START_CODE, start + 3)
        unit = access_unit[start + 3 : end if end >= 0 else None].rstrip(b"\0")
        if unit:
            yield unit
        start = end


def _together(units: Sequence[bytes]) -> bytes:
    """One unit as it is, or several as a STAP-A, which is as important as the most important of them (section 5.7)."""
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
