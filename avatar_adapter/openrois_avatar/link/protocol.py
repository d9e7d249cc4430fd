"""The framing of the engine link, without any input or output: bytes in, frozen messages out, and back.

Every message is a header of 16 bytes and a payload, all integers little-endian:

    header   magic `ORL1`, type u8, version u8 (1), flags u16 (0), length u32 (payload bytes), reserved u32 (0)
    VIDEO    seq u64, timestamp_ns u64, width u32, height u32, stride u32, format u32, flags u32, reserved u32, pixels
    AUDIO    seq u64, timestamp_ns u64, channels u32, reserved u32, s16 samples at 48 kHz, channels interleaved
    others   one JSON object in UTF-8

`timestamp_ns` is CLOCK_MONOTONIC, which the processes of one machine share. Pixels are `height` rows of `stride` bytes;
I420 and NV12 add their chroma planes without a gap, rows of `stride / 2` (I420, U then V) or `stride` bytes (NV12).
"""

from __future__ import annotations

import json
import struct
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import Enum, IntEnum
from typing import Any, Final, NamedTuple, TypeAlias

from openrois_avatar.link.messages import (
    MAX_CHANNELS,
    MAX_SIDE,
    MIN_SIDE,
    Bye,
    Command,
    Completed,
    Event,
    Hello,
    LinkError,
    Log,
    Pause,
    Welcome,
    command_from_json,
    event_from_json,
)

MAGIC: Final = b"ORL1"
VERSION: Final = 1
SAMPLE_RATE: Final = 48_000
MAX_JSON: Final = 64 * 1024
MAX_AUDIO: Final = 64 * 1024
MAX_VIDEO: Final = 64 * 1024 * 1024

HEADER: Final = struct.Struct("<4sBBHII")
VIDEO_HEADER: Final = struct.Struct("<QQIIIIII")
AUDIO_HEADER: Final = struct.Struct("<QQII")
_BOTTOM_UP: Final = 1
_UINT64: Final = 2**64 - 1

Bytes: TypeAlias = bytes | bytearray | memoryview


class MessageType(IntEnum):
    """The type byte of the header."""

    HELLO = 1
    WELCOME = 2
    VIDEO = 3
    AUDIO = 4
    COMMAND = 5
    EVENT = 6
    BYE = 7


class PixelFormat(IntEnum):
    """The format word of a VIDEO payload; the names in HELLO are the same in lower case."""

    BGRA = 1
    I420 = 2
    NV12 = 3


class Sender(Enum):
    """Who sends: decides which types a parser accepts, and which one must come first."""

    ENGINE = "engine"
    ADAPTER = "adapter"


@dataclass(frozen=True, slots=True)
class Video:
    """One picture. `pixels` may be a view into the buffer it was received in; the view keeps that buffer alive."""

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
class Audio:
    """A block of 48 kHz sound: `samples` are s16le, interleaved; `timestamp_ns` is when its first sample was made."""

    sequence: int
    timestamp_ns: int
    channels: int
    samples: Bytes

    def __post_init__(self) -> None:
        """Raise `LinkError` when the samples are not whole."""
        if not 1 <= self.channels <= MAX_CHANNELS:
            raise LinkError(f"AUDIO: channels from 1 to {MAX_CHANNELS} expected")
        if len(self.samples) > MAX_AUDIO - AUDIO_HEADER.size:
            raise LinkError(f"AUDIO: over the limit of {MAX_AUDIO} bytes")
        if len(self.samples) % (2 * self.channels):
            raise LinkError("AUDIO: the last sample is not whole")


Message: TypeAlias = Hello | Welcome | Video | Audio | Command | Event | Bye

_LIMITS: Final[Mapping[MessageType, int]] = {
    **dict.fromkeys(MessageType, MAX_JSON),
    MessageType.AUDIO: MAX_AUDIO,
    MessageType.VIDEO: MAX_VIDEO,
}
_FIRST: Final[Mapping[Sender, frozenset[MessageType]]] = {
    Sender.ENGINE: frozenset({MessageType.HELLO, MessageType.BYE}),
    Sender.ADAPTER: frozenset({MessageType.WELCOME, MessageType.BYE}),
}
_LATER: Final[Mapping[Sender, frozenset[MessageType]]] = {
    Sender.ENGINE: frozenset({MessageType.VIDEO, MessageType.AUDIO, MessageType.EVENT, MessageType.BYE}),
    Sender.ADAPTER: frozenset({MessageType.COMMAND, MessageType.AUDIO, MessageType.BYE}),
}


def check_picture(width: int, height: int, stride: int, pixel_format: PixelFormat, size: int) -> None:
    """Raise `LinkError` unless `size` bytes are exactly a picture of this shape."""
    if not (MIN_SIDE <= width <= MAX_SIDE and MIN_SIDE <= height <= MAX_SIDE):
        raise LinkError(f"VIDEO: width and height from {MIN_SIDE} to {MAX_SIDE} expected")
    planar = pixel_format is not PixelFormat.BGRA
    if planar and (width % 2 or height % 2 or stride % 2):
        raise LinkError("VIDEO: width, height and stride must be even in I420 and NV12")
    if stride < (width if planar else 4 * width):
        raise LinkError("VIDEO: stride shorter than a row")
    expected = stride * height * 3 // 2 if planar else stride * height
    if size > MAX_VIDEO - VIDEO_HEADER.size:
        raise LinkError(f"VIDEO: over the limit of {MAX_VIDEO} bytes")
    if size != expected:
        raise LinkError(f"VIDEO: {expected} bytes of pixels expected, {size} found")


def _refuse_constant(name: str) -> None:
    raise ValueError(name)


def _json_object(payload: memoryview) -> Mapping[str, Any]:
    try:
        body = json.loads(str(payload, "utf-8"), parse_constant=_refuse_constant)
    except (ValueError, RecursionError) as error:
        raise LinkError("the payload is not JSON") from error
    if not isinstance(body, dict):
        raise LinkError("the payload is not a JSON object")
    return body


def _video(payload: memoryview) -> Video:
    if len(payload) < VIDEO_HEADER.size:
        raise LinkError("VIDEO: shorter than its header")
    fields = VIDEO_HEADER.unpack_from(payload)
    sequence, timestamp_ns, width, height, stride, number, flags, reserved = fields
    if flags & ~_BOTTOM_UP or reserved:
        raise LinkError("VIDEO: unknown flags")
    if number not in PixelFormat.__members__.values():
        raise LinkError("VIDEO: unknown pixel format")
    pixels = payload[VIDEO_HEADER.size :]
    return Video(sequence, timestamp_ns, width, height, stride, PixelFormat(number), pixels, bool(flags))


def _audio(payload: memoryview) -> Audio:
    if len(payload) < AUDIO_HEADER.size:
        raise LinkError("AUDIO: shorter than its header")
    sequence, timestamp_ns, channels, reserved = AUDIO_HEADER.unpack_from(payload)
    if reserved:
        raise LinkError("AUDIO: unknown flags")
    return Audio(sequence, timestamp_ns, channels, payload[AUDIO_HEADER.size :])


_READERS: Final[Mapping[MessageType, Callable[[memoryview], Message]]] = {
    MessageType.HELLO: lambda payload: Hello.from_json(_json_object(payload)),
    MessageType.WELCOME: lambda payload: Welcome.from_json(_json_object(payload)),
    MessageType.VIDEO: _video,
    MessageType.AUDIO: _audio,
    MessageType.COMMAND: lambda payload: command_from_json(_json_object(payload)),
    MessageType.EVENT: lambda payload: event_from_json(_json_object(payload)),
    MessageType.BYE: lambda payload: Bye.from_json(_json_object(payload)),
}


class _Found(NamedTuple):
    message: Message | None
    used: int


class Parser:
    """Turns the bytes of one sender into messages; after a `LinkError` the connection is beyond repair.

    Two ways in, which may be mixed. `feed` takes what was received; payloads that lie whole in it are not copied, so
    it must not change as long as a `Video` or `Audio` of it is in use. `get_buffer` and `buffer_updated` let a socket
    write straight to where the payload stays.
    """

    def __init__(self, sender: Sender, allocate: Callable[[int], Any] = bytearray) -> None:
        """`allocate` makes the writable buffer of a payload; its content need not be zero."""
        self._allowed = _FIRST[sender]
        self._later = _LATER[sender]
        self._allocate = allocate
        self._header = memoryview(bytearray(HEADER.size))
        self._type: MessageType | None = None
        self._target = self._header
        self._filled = 0

    def get_buffer(self) -> memoryview:
        """Where the next bytes belong; never empty, and never longer than what the current message still lacks."""
        return self._target[self._filled :]

    def buffer_updated(self, count: int) -> Message | None:
        """Note that `count` bytes were written to `get_buffer()`; give the message they complete, if they do.

        Raises:
            LinkError: the bytes break the protocol.
        """
        self._filled += count
        if self._filled < len(self._target):
            return None
        if self._type is None:
            self._type, length = self._read_header(self._header)
            if length:
                self._target, self._filled = memoryview(self._allocate(length)).cast("B"), 0
                return None
            self._target = self._header[:0]
        kind, payload = self._type, self._target
        self._type, self._target, self._filled = None, self._header, 0
        return self._complete(kind, payload.toreadonly())

    def feed(self, data: Bytes) -> list[Message]:
        """The messages that `data` completes, in order.

        Raises:
            LinkError: the bytes break the protocol; messages completed before the fault are not given.
        """
        rest = memoryview(data).cast("B")
        messages: list[Message] = []
        while rest:
            found = self._whole(rest) or self._copy(rest)
            rest = rest[found.used :]
            if found.message is not None:
                messages.append(found.message)
        return messages

    def _whole(self, data: memoryview) -> _Found | None:
        """The message at the start of `data` without a copy, if it begins and ends there."""
        if self._type is not None or self._filled or len(data) < HEADER.size:
            return None
        kind, length = self._read_header(data)
        end = HEADER.size + length
        if len(data) < end:
            return None
        return _Found(self._complete(kind, data[HEADER.size : end].toreadonly()), end)

    def _copy(self, data: memoryview) -> _Found:
        target = self.get_buffer()
        used = min(len(target), len(data))
        target[:used] = data[:used]
        return _Found(self.buffer_updated(used), used)

    def _read_header(self, data: memoryview) -> tuple[MessageType, int]:
        magic, number, version, flags, length, reserved = HEADER.unpack_from(data)
        if magic != MAGIC:
            raise LinkError("bad magic: this is not the engine link, or its framing is lost")
        if version != VERSION:
            raise LinkError(f"version {version} is not spoken here, only {VERSION}")
        if flags or reserved:
            raise LinkError("unknown flags in the header")
        if number not in MessageType.__members__.values():
            raise LinkError(f"unknown message type {number}")
        kind = MessageType(number)
        if kind not in self._allowed:
            raise LinkError(f"{kind.name} is not expected here")
        if length > _LIMITS[kind]:
            raise LinkError(f"{kind.name} of {length} bytes is over the limit of {_LIMITS[kind]}")
        return kind, length

    def _complete(self, kind: MessageType, payload: memoryview) -> Message:
        try:
            message = _READERS[kind](payload)
        except LinkError as error:
            raise LinkError(f"bad {kind.name}: {error}") from error
        self._allowed = self._later
        return message


def _kind(message: Message) -> MessageType:
    match message:
        case Hello():
            return MessageType.HELLO
        case Welcome():
            return MessageType.WELCOME
        case Completed() | Log() | Pause():
            return MessageType.EVENT
        case Bye():
            return MessageType.BYE
        case _:
            return MessageType.COMMAND


def encode(message: Message) -> tuple[Bytes, ...]:
    """The buffers to send one after the other; the pixels and samples are passed through, not copied.

    Raises:
        LinkError: the message is too long for the link, or a number does not fit its field.
    """
    payload: Bytes
    match message:
        case Video():
            kind, payload = MessageType.VIDEO, memoryview(message.pixels).cast("B")
            head = _video_header(message)
        case Audio():
            kind, payload = MessageType.AUDIO, memoryview(message.samples).cast("B")
            head = _pack(AUDIO_HEADER, message.sequence, message.timestamp_ns, message.channels, 0)
        case _:
            kind, payload, head = _kind(message), _json_bytes(message.to_json()), b""
    length = len(head) + len(payload)
    if length > _LIMITS[kind]:
        raise LinkError(f"{kind.name} of {length} bytes is over the limit of {_LIMITS[kind]}")
    return HEADER.pack(MAGIC, kind, VERSION, 0, length, 0) + head, payload


def _json_bytes(body: Mapping[str, Any]) -> bytes:
    try:
        return json.dumps(body, separators=(",", ":"), allow_nan=False).encode()
    except ValueError as error:
        raise LinkError(str(error)) from error


def _video_header(video: Video) -> bytes:
    flags = _BOTTOM_UP if video.bottom_up else 0
    shape = video.width, video.height, video.stride, video.format
    return _pack(VIDEO_HEADER, video.sequence, video.timestamp_ns, *shape, flags, 0)


def _pack(layout: struct.Struct, sequence: int, timestamp_ns: int, *rest: int) -> bytes:
    if not 0 <= timestamp_ns <= _UINT64:
        raise LinkError("timestamp_ns does not fit 64 bits")
    return layout.pack(sequence & _UINT64, timestamp_ns, *rest)
