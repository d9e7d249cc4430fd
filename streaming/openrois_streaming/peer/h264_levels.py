"""The H.264 levels in an offer: aiortc names 3.1 whatever is sent, which is too low for more than 720p30."""

import re
from collections.abc import Sequence

from openrois_streaming.codecs import H264
from openrois_streaming.peer.stream import Stream
from openrois_streaming.rtp.h264_level import h264_level

_LEVEL = re.compile(r"(profile-level-id=[0-9A-Fa-f]{4})[0-9A-Fa-f]{2}")


def level_of(stream: Stream) -> int | None:
    """The level_idc of the largest pictures that a stream may be sent; None if it is not sent H.264."""
    if stream.publisher is None or H264 not in stream.codecs:
        return None
    rung = stream.publisher.renditions(H264, stream.caps.fps)[0].rung
    return None if rung is None else h264_level(rung.width, rung.height, rung.frame_rate)


def with_levels(sdp: str, levels: Sequence[int | None]) -> str:
    """`sdp` with these level_idcs in its m-sections (RFC 6184 section 8.1); None leaves one as it is.

    A description that was not offered so is answered in the same way: levels are no part of what both must agree on
    (`level-asymmetry-allowed`).
    """
    session, *sections = re.split(r"(?m)^(?=m=)", sdp)
    changed = [
        section if level is None else _LEVEL.sub(rf"\g<1>{level:02x}", section)
        for section, level in zip(sections, levels, strict=True)
    ]
    return "".join((session, *changed))
