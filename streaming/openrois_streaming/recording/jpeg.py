"""Pictures as JPEG."""

from fractions import Fraction
from typing import Final

import av
from av.video.reformatter import ColorRange

from openrois_streaming.source.av_frames import picture_frame
from openrois_streaming.source.source import RawVideo

_QUALITY: Final = "3"
"""Of FFmpeg's 2 (best) to 31: a picture that was H.264 before loses nothing that can be seen."""

_FULL_RANGE: Final = "yuvj420p"


def jpeg_of(raw: RawVideo) -> bytes:
    """Return a picture as a JPEG file (JFIF, 4:2:0)."""
    context = av.CodecContext.create("mjpeg", "w")
    context.width, context.height, context.pix_fmt = raw.width, raw.height, _FULL_RANGE
    context.time_base = Fraction(1, 1)
    context.options = {"qmin": _QUALITY, "qmax": _QUALITY}
    frame = picture_frame(raw).reformat(
        format=_FULL_RANGE, src_color_range=ColorRange.MPEG, dst_color_range=ColorRange.JPEG
    )
    frame.pts = 0
    return b"".join(bytes(packet) for packet in (*context.encode(frame), *context.encode(None)))
