"""Raw frames and the contract of their sources: cameras, game engines, synthetic pictures and sounds."""

from collections.abc import AsyncIterator
from contextlib import AbstractAsyncContextManager
from dataclasses import dataclass, field
from typing import Literal, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

PixelFormat = Literal["bgra", "bgr24", "rgb24", "nv12", "i420"]

SAMPLE_RATE = 48_000
"""Samples per second and channel of all raw audio."""

FrameT_co = TypeVar("FrameT_co", covariant=True)


@dataclass(frozen=True, slots=True, eq=False)
class RawVideo:
    """Raw picture.

    `data` (uint8) has the shape (height, width, 4) for `bgra`, (height, width, 3) for `bgr24` and `rgb24`, and
    (height * 3 / 2, width) for `i420` and `nv12`: the Y plane, then U and V, one after the other in `i420` and by turns
    in `nv12`, BT.601 limited range, width and height even. It may be a strided view. A source neither changes nor
    reuses the pixels of a frame that it has yielded.

    `sequence` counts the pictures of one source; a gap is a picture that was not made or did not arrive.
    `captured_at` is the moment the picture shows, in seconds of the media clock. `sender` names who sent it, where
    several do; empty for media of this machine.

    Raises:
        ValueError: `data` does not have the shape or type that `format`, `width` and `height` promise.
    """

    data: NDArray[np.uint8]
    format: PixelFormat
    width: int
    height: int
    sequence: int
    captured_at: float
    sender: str = field(default="", kw_only=True)

    def __post_init__(self) -> None:
        if self.data.dtype != np.uint8 or self.data.shape != picture_shape(self.format, self.width, self.height):
            raise ValueError(
                f"a {self.width}x{self.height} {self.format} picture cannot be {self.data.dtype} {self.data.shape}"
            )


@dataclass(frozen=True, slots=True, eq=False)
class EncodedVideo:
    """Picture that its source has encoded itself.

    `data` is an H.264 access unit in Annex B form, constrained baseline, or a VP8 frame (RFC 6386).

    `keyframe` is whether it can be decoded by itself. `sequence` counts the pictures of one source; after a gap nothing
    can be decoded until the next key frame. `captured_at` is as in `RawVideo`.
    """

    data: bytes
    keyframe: bool
    width: int
    height: int
    sequence: int
    captured_at: float


@dataclass(frozen=True, slots=True, eq=False)
class RawAudio:
    """Block of raw sound: `samples` is int16 of shape (n, channels), 48 kHz, one or two channels.

    `captured_at` is the moment of the first sample, in seconds of the media clock. `sender` is as in `RawVideo`.

    Raises:
        ValueError: `samples` has another shape or type.
    """

    samples: NDArray[np.int16]
    captured_at: float
    sender: str = field(default="", kw_only=True)

    def __post_init__(self) -> None:
        if self.samples.dtype != np.int16 or self.samples.ndim != 2 or self.samples.shape[1] not in (1, 2):
            raise ValueError(f"a block of sound cannot be {self.samples.dtype} {self.samples.shape}")


@dataclass(frozen=True, slots=True, eq=False)
class ReceivedVideo(RawVideo):
    """Raw picture that came from another machine; `captured_at` is estimated on this machine's media clock.

    `reported_at` is when it was captured by the sender's own reports, in epoch seconds of the sender's clock (RFC 3550
    section 6.4.1); None while there is no report that could be true. Without one `captured_at` counts from the fastest
    packet, with one it is late by the least travel time of a packet.
    """

    reported_at: float | None = None


@dataclass(frozen=True, slots=True, eq=False)
class ReceivedAudio(RawAudio):
    """Block of raw sound that came from another machine; its times are as in `ReceivedVideo`."""

    reported_at: float | None = None


class MediaSource(Protocol[FrameT_co]):
    """Source of media, which owns a device or a renderer, and its pace.

    `open()` acquires on entry and releases on exit (within a bounded time), and yields an iterator of frames as they
    become due. The iterator ends when the source has ended and raises when it has failed. A source can be opened again
    after it was closed; it is never open twice at once.
    """

    def open(self) -> AbstractAsyncContextManager[AsyncIterator[FrameT_co]]:
        """Acquire the source for as long as the context lasts."""
        ...


class EncodingSource(MediaSource[EncodedVideo], Protocol):
    """Source of pictures that encodes them itself, with one encoder for all viewers.

    Requests while it is not open, or that it cannot meet, are ignored.
    """

    def request_key_frame(self) -> None:
        """Make one of the next pictures a key frame, soon."""
        ...

    def set_bitrate(self, bitrate: int) -> None:
        """Aim at `bitrate` (bit/s) from now on."""
        ...


def picture_shape(pixel_format: PixelFormat, width: int, height: int) -> tuple[int, ...]:
    """Return the shape of the array that holds a picture.

    Raises:
        ValueError: a size below 2x2, or an odd one for `i420` and `nv12`, whose colour planes have half of it.
    """
    if width < 2 or height < 2:
        raise ValueError(f"a picture must be at least 2x2 pixels, not {width}x{height}")
    if pixel_format in ("i420", "nv12"):
        if width % 2 or height % 2:
            raise ValueError(f"{pixel_format} needs an even width and height, not {width}x{height}")
        return (height * 3 // 2, width)
    return (height, width, 4 if pixel_format == "bgra" else 3)
