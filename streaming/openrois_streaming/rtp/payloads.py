"""Which payload format a media type has, and how long a payload may be. Pure."""

from openrois_streaming.rtp.h264 import h264_payloads
from openrois_streaming.rtp.vp8 import vp8_payloads

PAYLOAD_LIMIT = 1172
"""Bytes of a payload, so that every packet passes where IPv6 does (1,280 bytes, RFC 8200 section 5): with 48 bytes of
IPv6 and UDP, 4 of a TURN channel, 12 of the RTP header, 24 of its extensions, 2 of RTX and 16 of SRTP it is 1,278."""


def payloads_of(mime_type: str, data: bytes) -> tuple[bytes, ...]:
    """The RTP payloads of one frame of `video/H264` or `video/VP8`, or of one block of `audio/opus` (RFC 7587).

    Raises:
        ValueError: another media type.
    """
    match mime_type:
        case "video/H264":
            return h264_payloads(data, PAYLOAD_LIMIT)
        case "video/VP8":
            return vp8_payloads(data, PAYLOAD_LIMIT)
        case "audio/opus":
            return (data,)
    raise ValueError(f"{mime_type} has no payload format here")
