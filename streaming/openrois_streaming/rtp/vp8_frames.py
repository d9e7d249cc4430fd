"""Check of a VP8 frame before it is passed on: whether it is a key frame, and its size (RFC 6386 section 9.1). Pure."""

from typing import Final

from openrois_streaming.rtp.h264_units import AccessUnit, NotPassable

_TAG: Final = 3
_START_CODE: Final = b"\x9d\x01\x2a"
_KEY_HEADER: Final = 10
_SIZE: Final = 0x3FFF  # the two bits above are a scale for display


def vp8_frame(data: bytes) -> AccessUnit:
    """Read the header of a frame.

    Raises:
        NotPassable: it is cut short, or a key frame without its start code.
    """
    if len(data) <= _TAG:
        raise NotPassable(f"a VP8 frame has more than {_TAG} bytes, not {len(data)}: send each whole")
    if data[0] & 1:
        return AccessUnit(False, None)
    if len(data) < _KEY_HEADER or data[_TAG : _TAG + 3] != _START_CODE:
        raise NotPassable("a VP8 key frame has no start code: send frames without the container's header")
    width, height = (int.from_bytes(data[at : at + 2], "little") & _SIZE for at in (6, 8))
    if not width or not height:
        raise NotPassable(f"a VP8 key frame cannot be {width}x{height}")
    return AccessUnit(True, (width, height))
