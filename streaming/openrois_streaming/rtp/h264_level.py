"""The level of an H.264 stream: how large its pictures are, and how many come in a second (table A-1). Pure."""

from math import ceil
from typing import Final

LEAST: Final = 31
"""Level 3.1, 1280x720 at 30 pictures a second, which every WebRTC endpoint can (RFC 7742 section 6.2)."""

_LEVELS: Final = (
    # level_idc, macroblocks a second, macroblocks of a picture
    (31, 108_000, 3_600),
    (32, 216_000, 5_120),
    (40, 245_760, 8_192),
    (42, 522_240, 8_704),
    (50, 589_824, 22_080),
    (51, 983_040, 36_864),
    (52, 2_073_600, 36_864),
    (60, 4_177_920, 139_264),
    (61, 8_355_840, 139_264),
)
_HIGHEST: Final = 62


def h264_level(width: int, height: int, frame_rate: float) -> int:
    """The lowest level_idc, from LEAST on, of pictures of `width` x `height` pixels, `frame_rate` of them a second."""
    macroblocks = ceil(width / 16) * ceil(height / 16)
    for level, a_second, a_picture in _LEVELS:
        if macroblocks <= a_picture and macroblocks * frame_rate <= a_second:
            return level
    return _HIGHEST
