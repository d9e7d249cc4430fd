"""Codecs that this machine can encode, by their media types."""

from typing import Final

import av.codec

H264: Final = "video/H264"
VP8: Final = "video/VP8"
OPUS: Final = "audio/opus"

LIBRARIES = {H264: "libx264", VP8: "libvpx", OPUS: "libopus"}
"""Media type of each codec (RFC 6184, RFC 7741, RFC 7587), best first, and the FFmpeg encoder that makes it."""


class CodecUnavailable(Exception):
    """Failure to encode a media type that is unknown, or that the installed PyAV has no encoder for."""


def codec_named(mime_type: str) -> str:
    """Return the exact spelling of a media type, which is case-insensitive (RFC 2045 section 5.1).

    Raises:
        CodecUnavailable: this machine cannot encode it.
    """
    for known, library in LIBRARIES.items():
        if known.lower() == mime_type.lower():
            if not _installed(library):
                raise CodecUnavailable(f"{known} needs {library}: install a build of PyAV that contains it")
            return known
    raise CodecUnavailable(f"there is no encoder for {mime_type!r}: use one of {', '.join(LIBRARIES)}")


def available_codecs() -> tuple[str, ...]:
    """Return the media types that this machine can encode, best first."""
    return tuple(known for known, library in LIBRARIES.items() if _installed(library))


def _installed(library: str) -> bool:
    try:
        av.codec.Codec(library, "w")
    except av.codec.codec.UnknownCodecError:
        return False
    return True
