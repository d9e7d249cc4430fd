"""The framing of the engine link, without any input or output: bytes in, frozen messages out, and back.

Every message is a header of 16 bytes and a payload, all integers little-endian:

    header   magic `ORL1`, type u8, version u8 (1), flags u16 (0), length u32 (payload bytes), reserved u32 (0)

The payloads of VIDEO, RING and AUDIO are those of `media`; all others are one JSON object in UTF-8.
"""

from __future__ import annotations

import json
import struct
from collections.abc import Callable, Mapping
from enum import Enum, IntEnum
from typing import Any, Final, TypeAlias

from openrois_avatar.link.media import (
    AUDIO_HEADER,
    MAX_AUDIO,
    MAX_VIDEO,
    RING_SIZE,
    SAMPLE_RATE,
    VIDEO_HEADER,
    Audio,
    Bytes,
    Doorbell,
    Encoded,
    PixelFormat,
    Video,
    media_header,
    read_audio,
    read_doorbell,
    read_video,
)
from openrois_avatar.link.messages import (
    Bye,
    Command,
    Event,
    Hello,
    LinkError,
    Welcome,
    command_from_json,
    event_from_json,
)

__all__ = [
    "AUDIO_HEADER",
    "HEADER",
    "MAGIC",
    "MAX_AUDIO",
    "MAX_JSON",
    "MAX_VIDEO",
    "SAMPLE_RATE",
    "VERSION",
    "VIDEO_HEADER",
    "Audio",
    "Bytes",
    "Doorbell",
    "Encoded",
    "Message",
    "MessageType",
    "Parser",
    "PixelFormat",
    "Sender",
    "Video",
    "encode",
]

MAGIC: Final = b"ORL1"
VERSION: Final = 1
MAX_JSON: Final = 64 * 1024
HEADER: Final = struct.Struct("<4sBBHII")


class MessageType(IntEnum):
    """The type byte of the header."""

    HELLO = 1
    WELCOME = 2
    VIDEO = 3
    AUDIO = 4
    COMMAND = 5
    EVENT = 6
    BYE = 7
    RING = 8


class Sender(Enum):
    """The sender of messages: decides which types a parser accepts, and which one must come first."""

    ENGINE = "engine"
    ADAPTER = "adapter"


Message: TypeAlias = Hello | Welcome | Video | Encoded | Doorbell | Audio | Command | Event | Bye

_BAD_MAGIC: Final = (
    f"bad magic: this is not the engine link, or its framing is lost; begin each message with {MAGIC.decode()}, "
    "and send as many bytes as its header says"
)
_SMALL: Final = 4096
"""Bytes of a message that are received before its type is known."""
_KINDS: Final = {int(kind): kind for kind in MessageType}
_LIMITS: Final[Mapping[MessageType, int]] = {
    **dict.fromkeys(MessageType, MAX_JSON),
    MessageType.AUDIO: MAX_AUDIO,
    MessageType.VIDEO: MAX_VIDEO,
    MessageType.RING: RING_SIZE,
}
_FIRST: Final[Mapping[Sender, frozenset[MessageType]]] = {
    Sender.ENGINE: frozenset({MessageType.HELLO, MessageType.BYE}),
    Sender.ADAPTER: frozenset({MessageType.WELCOME, MessageType.BYE}),
}
_LATER: Final[Mapping[Sender, frozenset[MessageType]]] = {
    Sender.ENGINE: frozenset(
        {MessageType.VIDEO, MessageType.RING, MessageType.AUDIO, MessageType.EVENT, MessageType.BYE}
    ),
    Sender.ADAPTER: frozenset({MessageType.COMMAND, MessageType.AUDIO, MessageType.BYE}),
}


def _too_long(kind: MessageType, length: int) -> LinkError:
    return LinkError(f"{kind.name} of {length} bytes is over the limit of {_LIMITS[kind]}; send less in one message")


def _refuse_constant(name: str) -> None:
    raise ValueError(name)


def _json_object(payload: memoryview) -> Mapping[str, Any]:
    try:
        body = json.loads(str(payload, "utf-8"), parse_constant=_refuse_constant)
    except (ValueError, RecursionError) as error:
        raise LinkError("the payload is not JSON: send one object in UTF-8, without NaN and Infinity") from error
    if not isinstance(body, dict):
        raise LinkError("the payload is not a JSON object: send one, with the members of the message")
    return body


_READERS: Final[Mapping[MessageType, Callable[[memoryview], Message]]] = {
    MessageType.HELLO: lambda payload: Hello.from_json(_json_object(payload)),
    MessageType.WELCOME: lambda payload: Welcome.from_json(_json_object(payload)),
    MessageType.VIDEO: read_video,
    MessageType.RING: read_doorbell,
    MessageType.AUDIO: read_audio,
    MessageType.COMMAND: lambda payload: command_from_json(_json_object(payload)),
    MessageType.EVENT: lambda payload: event_from_json(_json_object(payload)),
    MessageType.BYE: lambda payload: Bye.from_json(_json_object(payload)),
}


class Parser:
    """Converts the bytes of one sender into messages; after a `LinkError` the connection has to be closed.

    Two ways in, which may be mixed. `feed` takes received data; payloads that lie whole in it are not copied, so it
    must not change as long as a `Video` or `Audio` of it is in use. `get_buffer` and `buffer_updated` let a socket
    write: small messages to one place, several at once, and large ones straight to where they stay.
    """

    def __init__(self, sender: Sender, allocate: Callable[[int], Any] = bytearray) -> None:
        """`allocate` makes the writable buffer of a picture; its content need not be zero."""
        self._allowed = _FIRST[sender]
        self._later = _LATER[sender]
        self._allocate = allocate
        self._small = memoryview(bytearray(_SMALL))
        self._type: MessageType | None = None
        """The type of the message whose payload is in `_target`; None while that is `_small`."""
        self._target = self._small
        self._filled = 0

    def get_buffer(self) -> memoryview:
        """Return the buffer for the next bytes; never empty."""
        return self._target[self._filled :]

    def buffer_updated(self, count: int, take: Callable[[Message], None]) -> None:
        """Note that `count` bytes were written to `get_buffer()`, and call `take` with the messages that they complete.

        Raises:
            LinkError: the bytes break the protocol; `take` has got the messages before the fault.
        """
        self._filled += count
        if self._type is None:
            self._begun(take)
        elif self._filled == len(self._target):
            kind, payload = self._type, self._target
            self._type, self._target, self._filled = None, self._small, 0
            take(self._complete(kind, payload))

    def feed(self, data: Bytes) -> list[Message]:
        """Return the messages that `data` completes, in order.

        Raises:
            LinkError: the bytes break the protocol; messages completed before the fault are not given.
        """
        rest = memoryview(data).cast("B")
        messages: list[Message] = []
        while rest:
            used = self._whole(rest, messages) or self._copy(rest, messages)
            rest = rest[used:]
        return messages

    def _begun(self, take: Callable[[Message], None]) -> None:
        """Read the messages that are whole in `_small`; the rest moves to its beginning, or to where it stays."""
        start, end = 0, self._filled
        while end - start >= HEADER.size:
            kind, length = self._read_header(self._small[start:])
            payload = start + HEADER.size
            if payload + length <= end:
                start = payload + length
                # A copy: the next bytes are written over it.
                take(self._complete(kind, memoryview(self._small[payload:start].tobytes())))
            elif length > _SMALL - HEADER.size:
                self._type, self._filled = kind, end - payload
                self._target = memoryview(self._allocate(length) if kind is MessageType.VIDEO else bytearray(length))
                self._target[: self._filled] = self._small[payload:end]
                return
            else:
                break
        self._filled = end - start
        if start and self._filled:
            self._small[: self._filled] = self._small[start:end].tobytes()

    def _whole(self, data: memoryview, messages: list[Message]) -> int:
        """Read the message at the start of `data` without a copy, if it is whole; return its length, else 0."""
        if self._filled or self._type is not None or len(data) < HEADER.size:
            return 0
        kind, length = self._read_header(data)
        end = HEADER.size + length
        if len(data) < end:
            return 0
        messages.append(self._complete(kind, data[HEADER.size : end].toreadonly()))
        return end

    def _copy(self, data: memoryview, messages: list[Message]) -> int:
        """Copy the missing bytes of the message that has begun, as far as `data` has them; return their number."""
        lacking = len(self._target) - self._filled
        if self._type is None:
            lacking = HEADER.size - self._filled
            if lacking <= 0:
                lacking += self._read_header(self._small)[1]
        used = min(lacking, len(data), len(self._target) - self._filled)
        self.get_buffer()[:used] = data[:used]
        self.buffer_updated(used, messages.append)
        return used

    def _read_header(self, data: memoryview) -> tuple[MessageType, int]:
        magic, number, version, flags, length, reserved = HEADER.unpack_from(data)
        if magic != MAGIC:
            raise LinkError(_BAD_MAGIC)
        if version != VERSION:
            raise LinkError(f"version {version} is not spoken here, only {VERSION}; send {VERSION}")
        if flags or reserved:
            raise LinkError("unknown flags in the header; send 0 for flags and reserved")
        kind = _KINDS.get(number)
        if kind is None:
            raise LinkError(f"unknown message type {number}; send one from {min(_KINDS)} to {max(_KINDS)}")
        if kind not in self._allowed:
            expected = ", ".join(sorted(each.name for each in self._allowed))
            raise LinkError(f"{kind.name} is not expected here; send one of {expected}")
        if length > _LIMITS[kind]:
            raise _too_long(kind, length)
        return kind, length

    def _complete(self, kind: MessageType, payload: memoryview) -> Message:
        try:
            message = _READERS[kind](payload)
        except LinkError as error:
            raise LinkError(f"bad {kind.name}: {error}") from error
        self._allowed = self._later
        return message


def _kind(message: Hello | Welcome | Command | Event | Bye) -> MessageType:
    match message:
        case Hello():
            return MessageType.HELLO
        case Welcome():
            return MessageType.WELCOME
        case Bye():
            return MessageType.BYE
        case _:
            return MessageType.EVENT if isinstance(message, Event) else MessageType.COMMAND


def encode(message: Message) -> tuple[Bytes, ...]:
    """Return the buffers to send one after the other; the pixels and samples are passed through, not copied.

    Raises:
        LinkError: the message is too long for the link, or a number does not fit its field.
    """
    head, payload = b"", memoryview(b"")
    match message:
        case Video():
            kind, head, payload = MessageType.VIDEO, media_header(message), memoryview(message.pixels).cast("B")
        case Encoded():
            kind, head, payload = MessageType.VIDEO, media_header(message), memoryview(message.data).cast("B")
        case Doorbell():
            kind, head = MessageType.RING, media_header(message)
        case Audio():
            kind, head, payload = MessageType.AUDIO, media_header(message), memoryview(message.samples).cast("B")
        case _:
            kind, payload = _kind(message), memoryview(_json_bytes(message.to_json()))
    length = len(head) + len(payload)
    if length > _LIMITS[kind]:
        raise _too_long(kind, length)
    return HEADER.pack(MAGIC, kind, VERSION, 0, length, 0) + head, payload


def _json_bytes(body: Mapping[str, Any]) -> bytes:
    try:
        return json.dumps(body, separators=(",", ":"), allow_nan=False).encode()
    except ValueError as error:
        raise LinkError(f"the message cannot be sent: {error}; use finite numbers") from error
