"""The frames of a stream over NATS, and what two gateways say before there is one. Pure.

A frame is its kind (1 byte), its number (8 bytes) and a body. The frames of one direction are numbered from 0 without
a gap, whatever they are; `CUT` alone, which also comes from gateways that know of no such stream, has no number.
"""

import struct
from collections.abc import Sequence
from enum import IntEnum
from typing import Annotated, Any, Final, NamedTuple, TypeVar

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from openrois.cluster.subjects import MAX_NAME
from openrois.transport.stream import close_reason

__all__ = [
    "CUT_FRAME",
    "FRAME_HEAD",
    "MAX_BEAT",
    "MAX_GREETING",
    "PROTOCOL",
    "Accept",
    "Address",
    "Beat",
    "Dial",
    "Frame",
    "FrameFault",
    "FrameGap",
    "Kind",
    "pack_close",
    "pack_frame",
    "pack_grant",
    "pack_texts",
    "parse_close",
    "parse_frame",
    "parse_grant",
    "parse_said",
    "parse_texts",
]

PROTOCOL: Final = 1
"""The version of these frames. Fields may be added to what is JSON; all else needs another number."""

MAX_GREETING: Final = 32 << 10
"""Bytes of what dials or accepts."""

MAX_BEAT: Final = 8 << 10
"""Bytes of a sign of life."""

_HEAD: Final = struct.Struct("!BQ")
FRAME_HEAD: Final = _HEAD.size
"""Bytes before the body."""

_LENGTH: Final = struct.Struct("!I")
_GRANT: Final = struct.Struct("!Q")
_CODE: Final = struct.Struct("!H")


class Kind(IntEnum):
    """What a frame is.

    Its body is: of ACCEPT an `Accept`; of TEXT a message; of TEXTS several, each after its length; of PART a piece of a
    message, and of LAST its last piece; of CREDIT how much may be sent in all; of ALIVE the sender's `Address`; of
    CLOSE a code and a reason; of CUT nothing.
    """

    ACCEPT = 1
    TEXT = 2
    TEXTS = 3
    PART = 4
    LAST = 5
    CREDIT = 6
    ALIVE = 7
    CLOSE = 8
    CUT = 9


_KINDS: Final = {kind.value: kind for kind in Kind}

CUT_FRAME: Final = _HEAD.pack(Kind.CUT, 0)
"""Says that a stream has broken, or that there is none."""


class FrameFault(Exception):
    """What came is no frame that may come here."""


class FrameGap(FrameFault):
    """A frame is missing before the one that came."""


class Frame(NamedTuple):
    """A frame that came."""

    kind: Kind
    number: int
    body: bytes


class _Said(BaseModel):
    """Something in JSON; fields that a later version adds are left out."""

    model_config = ConfigDict(frozen=True, extra="ignore")


Name = Annotated[str, Field(min_length=1, max_length=MAX_NAME)]
Token = Annotated[str, Field(pattern=r"^[0-9a-f]{16}$")]


class Address(_Said):
    """Where frames to one end of a stream go.

    Attributes:
        link: the token of that gateway's connection to NATS.
        stream: the number of its end of the stream.
    """

    link: Token
    stream: int = Field(ge=0, lt=1 << 53)


class Accept(Address):
    """An end of a stream presents itself.

    Attributes:
        version: the frames that it speaks.
        window: how much it takes in before it grants more.
    """

    version: int = PROTOCOL
    window: int = Field(ge=64 << 10, le=1 << 30)


class Dial(Accept):
    """One gateway dials another.

    Attributes:
        gateway: the id of the one that dials.
        hello: what it asserts.
    """

    gateway: Name
    hello: dict[str, Any]


class Beat(_Said):
    """A sign of life.

    Attributes:
        gateway: the id of the gateway.
        instance: the token of its process.
        link: the token of its connection to NATS.
        version: of its program.
        number: of this sign among those of the process.
        attributes: what it tells all others.
        leaving: that it will be gone at once.
    """

    gateway: Name
    instance: Token
    link: Token
    version: str = Field(max_length=64)
    number: int = 0
    attributes: dict[str, Any] = Field(default_factory=dict)
    leaving: bool = False


Said = TypeVar("Said", bound=_Said)


def parse_said(model: type[Said], data: bytes, most: int = MAX_GREETING) -> Said:
    """Read JSON that another gateway sent.

    Raises:
        FrameFault: it is something else, or longer than `most` bytes.
    """
    if len(data) > most:
        raise FrameFault(f"a {model.__name__} of {len(data)} bytes is too long")
    try:
        return model.model_validate_json(data)
    except ValidationError as error:
        # What came is not repeated: it may hold what no log may.
        raise FrameFault(f"no {model.__name__}: {error.error_count()} fields do not fit") from None


def pack_frame(kind: Kind, number: int, body: bytes = b"") -> bytes:
    """Return a frame."""
    return _HEAD.pack(kind, number) + body


def parse_frame(data: bytes) -> Frame:
    """Read a frame.

    Raises:
        FrameFault: it is none.
    """
    if len(data) < FRAME_HEAD:
        raise FrameFault(f"{len(data)} bytes are too short for a frame")
    code, number = _HEAD.unpack_from(data)
    kind = _KINDS.get(code)
    if kind is None:
        raise FrameFault(f"frames of kind {code} are unknown")
    return Frame(kind, number, data[FRAME_HEAD:])


def pack_texts(texts: Sequence[bytes]) -> bytes:
    """Return the body of TEXTS."""
    return b"".join([part for text in texts for part in (_LENGTH.pack(len(text)), text)])


def parse_texts(body: bytes) -> list[bytes]:
    """Read the body of TEXTS.

    Raises:
        FrameFault: the lengths do not fit.
    """
    texts, at, size = [], 0, len(body)
    while at < size:
        begin = at + _LENGTH.size
        if begin > size:
            raise FrameFault("several messages are cut short within a length")
        (length,) = _LENGTH.unpack_from(body, at)
        at = begin + length
        if at > size:
            raise FrameFault("several messages are cut short")
        texts.append(body[begin:at])
    if not texts:
        raise FrameFault("several messages are none")
    return texts


def pack_grant(granted: int) -> bytes:
    """Return the body of CREDIT."""
    return _GRANT.pack(granted)


def parse_grant(body: bytes) -> int:
    """Read the body of CREDIT.

    Raises:
        FrameFault: it is none.
    """
    if len(body) != _GRANT.size:
        raise FrameFault(f"a credit has {_GRANT.size} bytes, not {len(body)}")
    (granted,) = _GRANT.unpack(body)
    return int(granted)


def pack_close(code: int, reason: str) -> bytes:
    """Return the body of CLOSE; the reason is cut to what fits into a close frame of a WebSocket."""
    return _CODE.pack(code) + close_reason(reason).encode()


def parse_close(body: bytes) -> tuple[int, str]:
    """Read the body of CLOSE.

    Raises:
        FrameFault: there is no code.
    """
    if len(body) < _CODE.size:
        raise FrameFault("a close has a code")
    (code,) = _CODE.unpack_from(body)
    return int(code), close_reason(body[_CODE.size :].decode(errors="replace"))
