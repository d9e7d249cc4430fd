"""Parameters that aiortc leaves out of offers: the H.264 level of a stream, and stereo sound of an application."""

import re
from collections.abc import Sequence
from math import ceil
from typing import Final

from openrois_streaming.codecs import H264
from openrois_streaming.peer.stream import Stream

_LEVEL = re.compile(r"(profile-level-id=[0-9A-Fa-f]{4})[0-9A-Fa-f]{2}")
_OPUS = re.compile(r"(?m)^a=rtpmap:(\d+) opus/48000/2\r\n")

_LEVELS: Final = (
    # level_idc, macroblocks a second, macroblocks of a picture (ITU-T H.264 table A-1); every WebRTC endpoint decodes
    # level 3.1, 1280x720 at 30 pictures a second (RFC 7742 section 6.2)
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


def level_of(stream: Stream) -> int | None:
    """Return the level_idc of the largest pictures of a stream; None if it is not sent H.264."""
    if stream.publisher is None or H264 not in stream.codecs:
        return None
    rung = stream.publisher.renditions(H264, stream.caps.fps)[0].rung
    return None if rung is None else h264_level(rung.width, rung.height, rung.frame_rate)


def with_levels(sdp: str, levels: Sequence[int | None]) -> str:
    """Return `sdp` with these level_idcs in its m-sections (RFC 6184 section 8.1); None leaves one as it is.

    The answer is the same without it: levels are no part of the agreement (`level-asymmetry-allowed`).
    """
    session, *sections = re.split(r"(?m)^(?=m=)", sdp)
    changed = [
        section if level is None else _LEVEL.sub(rf"\g<1>{level:02x}", section)
        for section, level in zip(sections, levels, strict=True)
    ]
    return "".join((session, *changed))


def with_stereo(sdp: str, wanted: Sequence[bool]) -> str:
    """Return `sdp` with its m-sections asking for two channels of Opus where `wanted` (RFC 7587 section 6.1)."""
    session, *sections = re.split(r"(?m)^(?=m=)", sdp)
    changed = [_asking(section) if want else section for section, want in zip(sections, wanted, strict=True)]
    return "".join((session, *changed))


def _asking(section: str) -> str:
    found = _OPUS.search(section)
    if found is None:
        return section
    parameters = re.compile(rf"(?m)^(a=fmtp:{found[1]} [^\r\n]*)")
    if parameters.search(section):
        return parameters.sub(r"\1;stereo=1", section)
    return f"{section[: found.end()]}a=fmtp:{found[1]} stereo=1\r\n{section[found.end() :]}"


def h264_level(width: int, height: int, frame_rate: float) -> int:
    """Return the lowest level_idc, from 3.1 on, of pictures of `width` x `height` pixels, `frame_rate` a second."""
    macroblocks = ceil(width / 16) * ceil(height / 16)
    for level, a_second, a_picture in _LEVELS:
        if macroblocks <= a_picture and macroblocks * frame_rate <= a_second:
            return level
    return _HIGHEST
