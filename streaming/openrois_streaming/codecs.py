"""The codecs that can be encoded here, by their media types."""

from typing import Final

import av.codec

H264: Final = "video/H264"
VP8: Final = "video/VP8"
OPUS: Final = "audio/opus"

LIBRARIES = {H264: "libx264", VP8: "libvpx", OPUS: "libopus"}
"""Media type of each codec (RFC 6184, RFC 7741, RFC 7587), best first, and the FFmpeg encoder that makes it."""


class CodecUnavailable(Exception):
    """The media type is not known, or the installed PyAV has no encoder for it. The text says which."""


def codec_named(mime_type: str) -> str:
    """The exact spelling of a media type, which is case-insensitive (RFC 2045 section 5.1).

    Raises:
        CodecUnavailable: it cannot be encoded here.
    """
    for known, library in LIBRARIES.items():
        if known.lower() == mime_type.lower():
            if not _installed(library):
                raise CodecUnavailable(f"{known} needs {library}, which the installed PyAV does not contain")
            return known
    raise CodecUnavailable(f"no encoder for {mime_type!r}; known are {', '.join(LIBRARIES)}")


def available_codecs() -> tuple[str, ...]:
    """Media types that can be encoded here, best first."""
    return tuple(known for known, library in LIBRARIES.items() if _installed(library))


def _installed(library: str) -> bool:
    try:
        av.codec.Codec(library, "w")
    except av.codec.codec.UnknownCodecError:
        return False
    return True
