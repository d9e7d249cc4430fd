"""Pictures and sound on the engine link, without any input or output: their layouts, and what they must fit.

All integers are little-endian:

    VIDEO    seq u64, timestamp_ns u64, width u32, height u32, stride u32, format u32, flags u32, reserved u32, pixels
    RING     the same 40 bytes, then slot u32 and reserved u32: the pixels are in that slot of the ring
    AUDIO    seq u64, timestamp_ns u64, channels u32, reserved u32, s16 samples at 48 kHz, channels interleaved

`timestamp_ns` is CLOCK_MONOTONIC, which the processes of one machine share. Pixels are `height` rows of `stride` bytes;
I420 and NV12 add their chroma planes without a gap, rows of `stride / 2` (I420, U then V) or `stride` bytes (NV12).
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from enum import IntEnum
from functools import lru_cache
from typing import Final, TypeAlias

from openrois_avatar.link.messages import MAX_CHANNELS, MAX_SIDE, MIN_SIDE, LinkError

SAMPLE_RATE: Final = 48_000
MAX_AUDIO: Final = 64 * 1024
MAX_VIDEO: Final = 64 * 1024 * 1024
"""Most bytes of an AUDIO and of a VIDEO payload; a slot of a ring holds no more than a VIDEO does."""

VIDEO_HEADER: Final = struct.Struct("<QQIIIIII")
SLOT: Final = struct.Struct("<II")
RING_SIZE: Final = VIDEO_HEADER.size + SLOT.size
AUDIO_HEADER: Final = struct.Struct("<QQII")
_BOTTOM_UP: Final = 1
_KEY_FRAME: Final = 2
_H264: Final = 4
"""The format word of encoded pictures."""
_UINT64: Final = 2**64 - 1

Bytes: TypeAlias = bytes | bytearray | memoryview


class PixelFormat(IntEnum):
    """The format word of a VIDEO payload with pixels; the names in HELLO are the same in lower case."""

    BGRA = 1
    I420 = 2
    NV12 = 3


_FORMATS: Final = {int(pixel_format): pixel_format for pixel_format in PixelFormat}
_NUMBERS: Final = ", ".join(f"{number} ({each.name})" for number, each in _FORMATS.items())


@dataclass(frozen=True, slots=True)
class Video:
    """One picture. `pixels` may be a view into the buffer it was received in; the view keeps that buffer alive.

    They can be written to where no other owner reads them.
    """

    sequence: int
    timestamp_ns: int
    width: int
    height: int
    stride: int
    format: PixelFormat
    pixels: Bytes
    bottom_up: bool = False

    def __post_init__(self) -> None:
        """Raise `LinkError` when the numbers do not describe the pixels."""
        check_picture(self.width, self.height, self.stride, self.format, len(memoryview(self.pixels).cast("B")))


@dataclass(frozen=True, slots=True)
class Encoded:
    """One picture that the engine has encoded: an H.264 access unit in Annex B form."""

    sequence: int
    timestamp_ns: int
    width: int
    height: int
    keyframe: bool
    data: Bytes

    def __post_init__(self) -> None:
        """Raise `LinkError` when size or length are not allowed."""
        _check_size(self.width, self.height)
        if len(self.data) > MAX_VIDEO - VIDEO_HEADER.size:
            raise LinkError(f"VIDEO: over the limit of {MAX_VIDEO} bytes; encode at a lower bit rate")


@dataclass(frozen=True, slots=True)
class Doorbell:
    """A picture with its pixels in a slot of the ring; they are written before this is sent."""

    sequence: int
    timestamp_ns: int
    width: int
    height: int
    stride: int
    format: PixelFormat
    slot: int
    bottom_up: bool = False

    def __post_init__(self) -> None:
        """Raise `LinkError` when the numbers do not describe a picture."""
        picture_size(self.width, self.height, self.stride, self.format)

    @property
    def size(self) -> int:
        """The number of bytes of the pixels."""
        return picture_size(self.width, self.height, self.stride, self.format)


@dataclass(frozen=True, slots=True)
class Audio:
    """A block of 48 kHz sound: `samples` are s16le, interleaved; `timestamp_ns` is when its first sample was made."""

    sequence: int
    timestamp_ns: int
    channels: int
    samples: Bytes

    def __post_init__(self) -> None:
        """Raise `LinkError` when the samples are not whole."""
        if not 1 <= self.channels <= MAX_CHANNELS:
            raise LinkError(f"AUDIO: channels must be 1 to {MAX_CHANNELS}, not {self.channels}")
        if len(self.samples) > MAX_AUDIO - AUDIO_HEADER.size:
            raise LinkError(f"AUDIO: over the limit of {MAX_AUDIO} bytes; send shorter blocks")
        if len(self.samples) % (2 * self.channels):
            raise LinkError("AUDIO: the last sample is not whole; send 2 bytes for each sample of each channel")


@lru_cache(maxsize=16)
def picture_size(width: int, height: int, stride: int, pixel_format: PixelFormat) -> int:
    """Return the number of bytes of a picture of this shape.

    Raises:
        LinkError: there is no such picture, or it is larger than the link allows.
    """
    _check_size(width, height)
    planar = pixel_format is not PixelFormat.BGRA
    if planar and (width % 2 or height % 2 or stride % 2):
        raise LinkError("VIDEO: width, height and stride must be even in I420 and NV12")
    row = width if planar else 4 * width
    if stride < row:
        raise LinkError(f"VIDEO: stride shorter than a row; it must be {row} bytes or more, not {stride}")
    size = stride * height * 3 // 2 if planar else stride * height
    if size > MAX_VIDEO - VIDEO_HEADER.size:
        raise LinkError(f"VIDEO: over the limit of {MAX_VIDEO} bytes; send smaller pictures")
    return size


def _check_size(width: int, height: int) -> None:
    if not (MIN_SIDE <= width <= MAX_SIDE and MIN_SIDE <= height <= MAX_SIDE):
        raise LinkError(f"VIDEO: width and height must be {MIN_SIDE} to {MAX_SIDE}, not {width}x{height}")


def check_picture(width: int, height: int, stride: int, pixel_format: PixelFormat, size: int) -> None:
    """Raise `LinkError` unless `size` bytes are exactly a picture of this shape."""
    expected = picture_size(width, height, stride, pixel_format)
    if size != expected:
        raise LinkError(f"VIDEO: {expected} bytes of pixels expected, {size} found; send whole rows of `stride` bytes")


def read_video(payload: memoryview) -> Video | Encoded:
    """Read a VIDEO payload; the pixels are a view of it."""
    if len(payload) < VIDEO_HEADER.size:
        raise LinkError(f"VIDEO: shorter than its header; begin the payload with its {VIDEO_HEADER.size} bytes")
    if VIDEO_HEADER.unpack_from(payload)[5] == _H264:
        return _read_encoded(payload)
    sequence, timestamp_ns, width, height, stride, pixel_format, bottom_up = _picture(payload)
    pixels = payload[VIDEO_HEADER.size :]
    return Video(sequence, timestamp_ns, width, height, stride, pixel_format, pixels, bottom_up)


def _read_encoded(payload: memoryview) -> Encoded:
    sequence, timestamp_ns, width, height, stride, _, flags, reserved = VIDEO_HEADER.unpack_from(payload)
    if flags & ~_KEY_FRAME or reserved or stride:
        raise LinkError(
            f"VIDEO: unknown flags, or a stride, with an encoded picture; send stride 0, and flags 0 or {_KEY_FRAME}"
        )
    return Encoded(sequence, timestamp_ns, width, height, bool(flags), payload[VIDEO_HEADER.size :])


def read_doorbell(payload: memoryview) -> Doorbell:
    """Read a RING payload."""
    if len(payload) != RING_SIZE:
        raise LinkError(f"RING: {RING_SIZE} bytes expected, {len(payload)} found; send the header, slot and reserved")
    sequence, timestamp_ns, width, height, stride, pixel_format, bottom_up = _picture(payload)
    slot, reserved = SLOT.unpack_from(payload, VIDEO_HEADER.size)
    if reserved:
        raise LinkError("RING: unknown flags; send 0 for reserved")
    return Doorbell(sequence, timestamp_ns, width, height, stride, pixel_format, slot, bottom_up)


def _picture(payload: memoryview) -> tuple[int, int, int, int, int, PixelFormat, bool]:
    """Read sequence, timestamp, width, height, stride, format and flag of the header of VIDEO and RING."""
    sequence, timestamp_ns, width, height, stride, number, flags, reserved = VIDEO_HEADER.unpack_from(payload)
    if flags & ~_BOTTOM_UP or reserved:
        raise LinkError(f"VIDEO: unknown flags; send 0, or {_BOTTOM_UP} for rows from bottom to top")
    pixel_format = _FORMATS.get(number)
    if pixel_format is None:
        raise LinkError(f"VIDEO: unknown pixel format {number}; send {_NUMBERS}")
    return sequence, timestamp_ns, width, height, stride, pixel_format, bool(flags)


def read_audio(payload: memoryview) -> Audio:
    """Read an AUDIO payload; the samples are a view of it."""
    if len(payload) < AUDIO_HEADER.size:
        raise LinkError(f"AUDIO: shorter than its header; begin the payload with its {AUDIO_HEADER.size} bytes")
    sequence, timestamp_ns, channels, reserved = AUDIO_HEADER.unpack_from(payload)
    if reserved:
        raise LinkError("AUDIO: unknown flags; send 0 for reserved")
    return Audio(sequence, timestamp_ns, channels, payload[AUDIO_HEADER.size :])


def media_header(message: Video | Encoded | Doorbell | Audio) -> bytes:
    """Return the bytes before the pixels or samples, or the whole payload of a doorbell.

    Raises:
        LinkError: a number does not fit its field.
    """
    if isinstance(message, Audio):
        return _pack(AUDIO_HEADER, message.sequence, message.timestamp_ns, message.channels, 0)
    if isinstance(message, Encoded):
        flags = _KEY_FRAME if message.keyframe else 0
        shape = message.width, message.height, 0, _H264
        return _pack(VIDEO_HEADER, message.sequence, message.timestamp_ns, *shape, flags, 0)
    flags = _BOTTOM_UP if message.bottom_up else 0
    layout = message.width, message.height, message.stride, message.format
    head = _pack(VIDEO_HEADER, message.sequence, message.timestamp_ns, *layout, flags, 0)
    return head + SLOT.pack(message.slot, 0) if isinstance(message, Doorbell) else head


def _pack(layout: struct.Struct, sequence: int, timestamp_ns: int, *rest: int) -> bytes:
    if not 0 <= timestamp_ns <= _UINT64:
        raise LinkError("timestamp_ns does not fit 64 bits; use CLOCK_MONOTONIC in nanoseconds")
    return layout.pack(sequence & _UINT64, timestamp_ns, *rest)
