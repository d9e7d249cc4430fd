"""The messages of Pixel Streaming's data channel: one byte that names the message, and its packed fields. Pure.

A streamer sends its tables to each player, and both use them from then on; these are the usual ones.
"""

import json
import struct
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Final, Literal, TypeAlias

__all__ = [
    "FROM_STREAMER",
    "MESSAGE_LIMIT",
    "TO_STREAMER",
    "Layout",
    "Message",
    "MessageError",
    "flag",
    "read",
    "tables",
    "text",
    "written",
]

MESSAGE_LIMIT: Final = 4096
"""Bytes of a message of a player."""

FIELDS_LIMIT: Final = 64
"""Most fields of a message; only touch messages have many."""

Field: TypeAlias = Literal["uint8", "uint16", "int16", "double", "string"]
Value: TypeAlias = int | float | str


class MessageError(ValueError):
    """A malformed message of a player; the text says what is wrong."""


@dataclass(frozen=True, slots=True)
class Layout:
    """The id of a message, and its fields."""

    id: int
    structure: tuple[Field, ...] = ()


@dataclass(frozen=True, slots=True)
class Message:
    """A message by its name, and the values of its fields in their order."""

    name: str
    values: tuple[Value, ...] = ()


_TOUCH: Final[tuple[Field, ...]] = ("uint8", "uint16", "uint16", "uint8", "uint8", "uint8")
_BUTTON: Final[tuple[Field, ...]] = ("uint8", "uint16", "uint16")
_PAD: Final[tuple[Field, ...]] = ("uint8", "uint8", "uint8")

TO_STREAMER: Final[Mapping[str, Layout]] = {
    "IFrameRequest": Layout(0),
    "RequestQualityControl": Layout(1),
    "FpsRequest": Layout(2),
    "AverageBitrateRequest": Layout(3),
    "StartStreaming": Layout(4),
    "StopStreaming": Layout(5),
    "LatencyTest": Layout(6, ("string",)),
    "RequestInitialSettings": Layout(7),
    "TestEcho": Layout(8),
    "UIInteraction": Layout(50, ("string",)),
    "Command": Layout(51, ("string",)),
    "TextboxEntry": Layout(52, ("string",)),
    "KeyDown": Layout(60, ("uint8", "uint8")),
    "KeyUp": Layout(61, ("uint8",)),
    "KeyPress": Layout(62, ("uint16",)),
    "MouseEnter": Layout(70),
    "MouseLeave": Layout(71),
    "MouseDown": Layout(72, _BUTTON),
    "MouseUp": Layout(73, _BUTTON),
    "MouseMove": Layout(74, ("uint16", "uint16", "int16", "int16")),
    "MouseWheel": Layout(75, ("int16", "uint16", "uint16")),
    "MouseDouble": Layout(76, _BUTTON),
    "TouchStart": Layout(80, _TOUCH),
    "TouchEnd": Layout(81, _TOUCH),
    "TouchMove": Layout(82, _TOUCH),
    "GamepadButtonPressed": Layout(90, _PAD),
    "GamepadButtonReleased": Layout(91, _PAD),
    "GamepadAnalog": Layout(92, ("uint8", "uint8", "double")),
    "GamepadConnected": Layout(93),
    "GamepadDisconnected": Layout(94, ("uint8",)),
}
"""The messages of a player. The first field of a touch message counts its touches, each of which has the others."""

FROM_STREAMER: Final[Mapping[str, Layout]] = {
    "QualityControlOwnership": Layout(0, ("uint8",)),
    "Response": Layout(1, ("string",)),
    "Command": Layout(2, ("string",)),
    "LatencyTest": Layout(6, ("string",)),
    "InitialSettings": Layout(7, ("string",)),
    "TestEcho": Layout(11),
    "InputControlOwnership": Layout(12, ("uint8",)),
    "GamepadResponse": Layout(13, ("string",)),
    "Protocol": Layout(255, ("string",)),
}
"""The messages of a streamer that are used here. A text fills the rest of a message: it has no length."""

_NAMES: Final = {layout.id: name for name, layout in TO_STREAMER.items()}
_PACKED: Final[Mapping[Field, struct.Struct]] = {
    "uint8": struct.Struct("<B"),
    "uint16": struct.Struct("<H"),
    "int16": struct.Struct("<h"),
    "double": struct.Struct("<d"),
}


def read(data: bytes) -> Message | None:
    """Read a message of a player; None if it has an unknown id, which is no fault.

    Raises:
        MessageError: it is too long, too short, or does not match its layout.
    """
    if not 0 < len(data) <= MESSAGE_LIMIT:
        raise MessageError(f"a message must have 1 to {MESSAGE_LIMIT} bytes, not {len(data)}")
    name = _NAMES.get(data[0])
    if name is None:
        return None
    structure = TO_STREAMER[name].structure
    if structure is _TOUCH:
        structure = _fingers(name, data)
    values = tuple(_values(name, structure, data))
    return Message(name, values)


def written(message: Message) -> bytes:
    """Return a message as a player sends it; its values must fit.

    Raises:
        MessageError: too many or too few values.
    """
    layout = TO_STREAMER[message.name]
    structure = layout.structure
    if structure is _TOUCH:
        structure = structure[:1] + structure[1:] * int(message.values[0])
    if len(message.values) != len(structure):
        raise MessageError(f"{message.name}: must have {len(structure)} fields, not {len(message.values)}")
    parts = [bytes([layout.id])]
    for field, value in zip(structure, message.values, strict=True):
        if field == "string":
            encoded = str(value).encode("utf-16-le", "surrogatepass")
            parts.append(_PACKED["uint16"].pack(len(encoded) // 2) + encoded)
        else:
            parts.append(_PACKED[field].pack(value))
    return b"".join(parts)


def flag(name: str, on: bool) -> bytes:
    """Return a message of the streamer with a truth value, or without fields if its layout has none."""
    layout = FROM_STREAMER[name]
    return bytes([layout.id, on]) if layout.structure else bytes([layout.id])


def text(name: str, value: str) -> bytes:
    """Return a message of the streamer with a text."""
    return bytes([FROM_STREAMER[name].id]) + value.encode("utf-16-le", "surrogatepass")


def tables() -> tuple[bytes, ...]:
    """Return the messages with the tables of both directions."""
    return tuple(
        text("Protocol", json.dumps({"Direction": direction, **{name: _shown(each) for name, each in table.items()}}))
        for direction, table in enumerate((TO_STREAMER, FROM_STREAMER))
    )


def _shown(layout: Layout) -> dict[str, object]:
    return {"id": layout.id, "structure": list(layout.structure)}


def _fingers(name: str, data: bytes) -> tuple[Field, ...]:
    if len(data) < 2:
        raise MessageError(f"{name}: it ends within uint8")
    structure = _TOUCH[:1] + _TOUCH[1:] * data[1]
    if len(structure) > FIELDS_LIMIT:
        raise MessageError(f"{name}: must have at most {FIELDS_LIMIT} fields, not {len(structure)}")
    return structure


def _values(name: str, structure: tuple[Field, ...], data: bytes) -> Iterator[Value]:
    place = 1
    for field in structure:
        size = _PACKED["uint16" if field == "string" else field]
        if place + size.size > len(data):
            raise MessageError(f"{name}: it ends within {field}")
        (value,) = size.unpack_from(data, place)
        place += size.size
        if field == "string":
            raw = data[place : place + 2 * value]
            if len(raw) < 2 * value:
                raise MessageError(f"{name}: its text ends too early")
            place += len(raw)
            value = raw.decode("utf-16-le", "surrogatepass")
        yield value
    if place != len(data):
        raise MessageError(f"{name}: {len(data) - place} bytes too many")
