"""Contract of an encoder with the thread that runs it."""

from collections.abc import Sequence
from typing import NamedTuple, Protocol, TypeVar

RawT_contra = TypeVar("RawT_contra", contravariant=True)


class Chunk(NamedTuple):
    """Encoded picture or block of sound; `pts` in the units of the encoder's clock rate."""

    data: bytes
    pts: int
    keyframe: bool
    captured_at: float
    payloads: tuple[bytes, ...]
    """The same in RTP payloads."""


class Encoder(Protocol[RawT_contra]):
    """Encoder of one codec. All calls come from one thread, in which it was also made."""

    def encode(self, raw: RawT_contra, *, key_frame: bool) -> Sequence[Chunk]:
        """Encode one raw frame; the result holds nothing back for later, except sound that fills no packet yet."""
        ...

    def set_bitrate(self, bitrate: int) -> None:
        """Aim at `bitrate` (bit/s) from the next frame on."""
        ...
