"""Encoded frames, which all viewers of a rendition share."""

from dataclasses import dataclass

VIDEO_CLOCK_RATE = 90_000
"""RTP clock of all video codecs (RFC 6184 section 8.2.1, RFC 7741 section 6.1)."""

AUDIO_CLOCK_RATE = 48_000
"""RTP clock of Opus (RFC 7587 section 4.1)."""


@dataclass(frozen=True, slots=True)
class EncodedFrame:
    """Picture or block of sound, encoded once for all viewers.

    `data` is an H.264 access unit in Annex B form, a VP8 frame, or an Opus packet; `payloads` are the same for RTP.
    `pts` is the capture time on the media clock in units of `1 / clock_rate` seconds, not reduced to 32 bits; it grows
    with every frame of a rendition.
    `keyframe` is true for every block of sound. `sequence` counts the frames of the rendition, without gaps, and
    goes on when its encoder is stopped and started again. `captured_at` is in seconds of the media clock.
    """

    data: bytes
    payloads: tuple[bytes, ...]
    pts: int
    clock_rate: int
    keyframe: bool
    sequence: int
    captured_at: float
