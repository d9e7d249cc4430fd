"""The interface definition language of ROS 2: `.msg`, `.srv` and `.action` texts. Pure.

Source: https://docs.ros.org/en/jazzy/Concepts/Basic/About-Interfaces.html. What it says is read but for `wchar` and
`wstring`, which no interface that a robot is driven by has.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import isfinite
from types import MappingProxyType
from typing import Final, TypeAlias

__all__ = [
    "PRIMITIVES",
    "ActionDefinition",
    "Array",
    "Constant",
    "DefinitionError",
    "Field",
    "FieldType",
    "MessageDefinition",
    "ServiceDefinition",
    "Value",
    "parse_action",
    "parse_message",
    "parse_service",
]

MAX_TEXT: Final = 100_000
"""Characters of one definition."""
MAX_LENGTH: Final = 65_536
"""Items of an array of fixed length, and the largest bound."""

Value: TypeAlias = bool | int | float | str

_INTEGERS: Final[Mapping[str, tuple[int, int]]] = MappingProxyType(
    {
        "byte": (0, 255),
        "char": (0, 255),
        **{f"int{bits}": (-(1 << bits - 1), (1 << bits - 1) - 1) for bits in (8, 16, 32, 64)},
        **{f"uint{bits}": (0, (1 << bits) - 1) for bits in (8, 16, 32, 64)},
    }
)
"""The integer types, and the least and the largest number of each."""

PRIMITIVES: Final = frozenset({"bool", "float32", "float64", "string", *_INTEGERS})

_NAME: Final = r"[A-Za-z][A-Za-z0-9_]*"
_TYPE: Final = re.compile(
    rf"(?:(?P<package>{_NAME})/(?:msg/)?)?(?P<name>{_NAME})(?:<=(?P<bound>\d{{1,9}}))?"
    r"(?P<array>\[(?P<upper><=)?(?P<length>\d{1,9})?\])?"
)
_LINE: Final = re.compile(rf"(?P<type>[^\s=]+(?:<=\d+)?(?:\[<=\d*\])?)\s+(?P<name>{_NAME})\s*(?P<rest>.*)", re.DOTALL)
_FIELD_NAME: Final = re.compile(r"[a-z]([a-z0-9_]*[a-z0-9])?")
_CONSTANT_NAME: Final = re.compile(r"[A-Z]([A-Z0-9_]*[A-Z0-9])?")
_COMMENT: Final = re.compile(r"#.*")
_STRING: Final = re.compile(r"'(?P<single>(?:[^'\\]|\\.)*)'|\"(?P<double>(?:[^\"\\]|\\.)*)\"")


class DefinitionError(ValueError):
    """A text that is no interface definition; the sentence has the interface, the line and the mistake."""


@dataclass(frozen=True, slots=True)
class Array:
    """The items of a field.

    Attributes:
        length: of an array, or the bound of a sequence; None: a sequence without one.
        is_fixed: whether it is an array of this length.
    """

    length: int | None = None
    is_fixed: bool = False


@dataclass(frozen=True, slots=True)
class FieldType:
    """The type of a field or a constant.

    Attributes:
        name: one of `PRIMITIVES`, or a message: `geometry_msgs/msg/Twist`.
        bound: characters that a string has at most; None: any number.
        array: how many items it has; None: it is one value.
    """

    name: str
    bound: int | None = None
    array: Array | None = None

    @property
    def is_primitive(self) -> bool:
        """Whether it is no message."""
        return self.name in PRIMITIVES


@dataclass(frozen=True, slots=True)
class Field:
    """A field of a message; `default` is None where the text gives none."""

    type: FieldType
    name: str
    default: Value | tuple[Value, ...] | None = None


@dataclass(frozen=True, slots=True)
class Constant:
    """A constant of a message."""

    type: FieldType
    name: str
    value: Value


@dataclass(frozen=True, slots=True)
class MessageDefinition:
    """A message: its name, such as `geometry_msgs/msg/Twist`, its fields in order, and its constants."""

    name: str
    fields: tuple[Field, ...]
    constants: tuple[Constant, ...] = ()


@dataclass(frozen=True, slots=True)
class ServiceDefinition:
    """A service, such as `std_srvs/srv/SetBool`: the messages of both directions."""

    name: str
    request: MessageDefinition
    response: MessageDefinition


@dataclass(frozen=True, slots=True)
class ActionDefinition:
    """An action, such as `nav2_msgs/action/NavigateToPose`: its three messages."""

    name: str
    goal: MessageDefinition
    result: MessageDefinition
    feedback: MessageDefinition


def parse_message(name: str, text: str) -> MessageDefinition:
    """Return the message of a `.msg` text.

    Args:
        name: of the interface: `geometry_msgs/msg/Twist`.
        text: of the definition.

    Raises:
        DefinitionError: the text is none.
    """
    return _message(name, name, text)


def parse_service(name: str, text: str) -> ServiceDefinition:
    """Return the service of a `.srv` text; raises as `parse_message`."""
    request, response = _parts(name, text, 2)
    return ServiceDefinition(
        name, _message(name, f"{name}_Request", request), _message(name, f"{name}_Response", response)
    )


def parse_action(name: str, text: str) -> ActionDefinition:
    """Return the action of an `.action` text; raises as `parse_message`."""
    goal, result, feedback = _parts(name, text, 3)
    return ActionDefinition(
        name,
        _message(name, f"{name}_Goal", goal),
        _message(name, f"{name}_Result", result),
        _message(name, f"{name}_Feedback", feedback),
    )


def _parts(name: str, text: str, count: int) -> Sequence[str]:
    parts = re.split(r"^---[ \t]*$", text, flags=re.MULTILINE)
    if len(parts) != count:
        raise DefinitionError(f"{name}: expected {count} parts with a line --- between them, not {len(parts)}")
    return parts


def _message(interface: str, name: str, text: str) -> MessageDefinition:
    if len(text) > MAX_TEXT:
        raise DefinitionError(f"{interface} has more than {MAX_TEXT} characters")
    fields: list[Field] = []
    constants: list[Constant] = []
    names: set[str] = set()
    package = interface.partition("/")[0]
    for line in text.splitlines():
        stripped = _without_comment(line)
        if not stripped:
            continue
        try:
            entry = _entry(stripped, package)
        except ValueError as error:
            raise DefinitionError(f"{interface}: {stripped!r}: {error}") from None
        if entry.name in names:
            raise DefinitionError(f"{interface}: {stripped!r}: {entry.name} stands there twice")
        names.add(entry.name)
        if isinstance(entry, Constant):
            constants.append(entry)
        else:
            fields.append(entry)
    return MessageDefinition(name, tuple(fields), tuple(constants))


def _without_comment(line: str) -> str:
    """Return a line without its comment; a # within quotes begins none, and neither does one in a string constant."""
    found = _LINE.match(line.strip())
    if found is not None and found["type"].startswith("string") and "#" in line:
        rest = found["rest"]
        if rest.startswith("="):
            return line.strip()
        quoted = _STRING.match(rest)
        if quoted is not None:
            return line.strip()[: -len(rest)] + quoted[0]
    return _COMMENT.sub("", line).strip()


def _entry(line: str, package: str) -> Field | Constant:
    found = _LINE.fullmatch(line)
    if found is None:
        raise ValueError("expected a type and a name")
    kind = _type(found["type"], package)
    name, rest = found["name"], found["rest"]
    if rest.startswith("="):
        if kind.array is not None or not kind.is_primitive:
            raise ValueError("a constant must be of a primitive type")
        if not _CONSTANT_NAME.fullmatch(name):
            raise ValueError(f"the constant {name} must be in upper case, with single words between _")
        return Constant(kind, name, _constant(kind, rest[1:].strip()))
    if not _FIELD_NAME.fullmatch(name) or "__" in name:
        raise ValueError(f"the field {name} must be in lower case, with single _ between its words")
    return Field(kind, name, _default(kind, rest) if rest else None)


def _type(text: str, package: str) -> FieldType:
    found = _TYPE.fullmatch(text)
    if found is None:
        raise ValueError(f"{text} is no type")
    name, bound = found["name"], None if found["bound"] is None else int(found["bound"])
    if bound is not None and (name != "string" or not 1 <= bound <= MAX_LENGTH):
        raise ValueError(f"only a string may have a bound, of 1 to {MAX_LENGTH}")
    array = _array(found["length"], found["upper"] is not None) if found["array"] else None
    if found["package"] is None and name in PRIMITIVES:
        return FieldType(name, bound, array)
    if not name[0].isupper():
        raise ValueError(f"{name} is no type")
    return FieldType(f"{found['package'] or package}/msg/{name}", None, array)


def _array(length: str | None, is_bound: bool) -> Array:
    if length is None:
        if is_bound:
            raise ValueError("a bound is missing behind <=")
        return Array()
    if not 1 <= int(length) <= MAX_LENGTH:
        raise ValueError(f"an array must have 1 to {MAX_LENGTH} items")
    return Array(int(length), not is_bound)


def _constant(kind: FieldType, text: str) -> Value:
    if kind.name == "string":
        quoted = _STRING.fullmatch(text)
        return text if quoted is None else _unquoted(quoted)
    return _value(kind, text)


def _default(kind: FieldType, text: str) -> Value | tuple[Value, ...]:
    if not kind.is_primitive:
        raise ValueError("a message can have no default")
    if kind.array is None:
        return _value(kind, text)
    if not (text.startswith("[") and text.endswith("]")):
        raise ValueError("the default of an array must stand in [ ]")
    inner = text[1:-1].strip()
    if kind.name == "string":
        items = [_unquoted(each) for each in _STRING.finditer(inner)]
        if _STRING.sub("", inner).replace(",", "").strip():
            raise ValueError("the strings of a default must be quoted")
        values: tuple[Value, ...] = tuple(items)
    else:
        values = tuple(_value(kind, each.strip()) for each in inner.split(",")) if inner else ()
    length = kind.array.length
    if length is not None and (len(values) > length or (kind.array.is_fixed and len(values) != length)):
        raise ValueError(f"the default must have {length} items, not {len(values)}")
    return values


def _value(kind: FieldType, text: str) -> Value:
    if kind.name == "string":
        quoted = _STRING.fullmatch(text)
        if quoted is None:
            raise ValueError("the default of a string must be quoted")
        return _unquoted(quoted)
    if kind.name == "bool":
        if text.lower() not in ("true", "false", "0", "1"):
            raise ValueError(f"{text} is neither true nor false")
        return text.lower() in ("true", "1")
    if kind.name in ("float32", "float64"):
        number = float(text) if re.fullmatch(r"[-+0-9.eE]{1,40}", text) else float("nan")
        if not isfinite(number):
            raise ValueError(f"{text} is no number")
        return number
    least, most = _INTEGERS[kind.name]
    if not re.fullmatch(r"[-+]?(0x[0-9a-fA-F]{1,16}|[0-9]{1,20})", text):
        raise ValueError(f"{text} is no integer")
    integer = int(text, 16 if "x" in text else 10)
    if not least <= integer <= most:
        raise ValueError(f"{text} is no {kind.name}")
    return integer


def _unquoted(found: re.Match[str]) -> str:
    inside = found["single"] if found["single"] is not None else found["double"]
    return re.sub(r"\\(.)", r"\1", inside)
