"""Named, typed values: what a message carries, as a Python object on one side and as text on the wire on the other."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from datetime import datetime
from enum import StrEnum
from functools import cache
from types import NoneType, UnionType
from typing import Annotated, Any, Final, Literal, Self, TypeVar, Union, get_args, get_origin

from pydantic import BaseModel, ConfigDict, ValidationError

from openrois.types.codes import ComponentStatus, StreamStatus
from openrois.types.messages import Result
from openrois.types.profiles import ParameterProfile, RoISIdentifier
from openrois.types.values import decode_value, encode_value, read_date_time

__all__ = ["Data", "Payload", "type_code"]

_Named = TypeVar("_Named", bound=Result)

_CODES: Final[Mapping[type, str]] = {
    bool: "bool",
    int: "int",
    float: "double",
    str: "string",
    datetime: "DateTime",
    ComponentStatus: "Component_Status",
    StreamStatus: "Stream_Status",
}


@dataclass(frozen=True, slots=True)
class Data:
    """What is said about one value, beside its Python type.

    Attributes:
        code: the `data_type_ref` of the profile, spelled as in the source; empty to derive it from the Python type.
        obligation: mandatory, optional or conditional in the text's table, which a profile does not say.
        description: a sentence for the profile.
        source: where the value is defined: `XML`, `IDL`, `text`, or `OpenRoIS` for a value of our own.
        note: what differs between the sources, or why what stands here is not theirs.
        read_only: of a parameter, whether the component alone sets it.
    """

    code: str = ""
    obligation: Literal["M", "O", "C"] = "M"
    description: str = ""
    source: Literal["XML", "IDL", "text", "OpenRoIS"] = "XML"
    note: str = ""
    read_only: bool = False

    @property
    def remark(self) -> str:
        """The description as applications read it: a profile has no other place that says what is read only."""
        return "; ".join(part for part in (self.description, "read only" if self.read_only else "") if part)


class Payload(BaseModel):
    """The results or arguments of a message, or the parameters of a component. A value of None is absent on the wire.

    A subclass declares one field for each value; `Annotated[..., Data(...)]` says more about it. Without `Data` the
    `data_type_ref` follows from the Python type: `int`, `double`, `bool`, `string` (also of a `StrEnum` and of literal
    texts), `DateTime`, and `T[]` of lists and tuples.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    @classmethod
    def data(cls) -> Mapping[str, Data]:
        """Return what is said about each value; `code` is never empty here."""
        return _data_of(cls)

    @classmethod
    def profiles(cls) -> tuple[ParameterProfile, ...]:
        """Return the values' profiles, in order."""
        return tuple(
            ParameterProfile(
                name=name,
                data_type_ref=RoISIdentifier(code=data.code),
                default_value=_default(cls, name, data.code),
                description=data.remark,
            )
            for name, data in cls.data().items()
        )

    @classmethod
    def from_texts(cls, texts: Mapping[str, str]) -> Self:
        """Read values from their texts by name; a name that the payload does not have is passed over.

        Raises:
            ValueError: one does not fit its type, or is missing.
        """
        values: dict[str, Any] = {}
        for name, data in cls.data().items():
            if name in texts:
                try:
                    value = decode_value(data.code, texts[name])
                    values[name] = _moments(value) if _scalar_of(cls, name) is datetime else value
                except ValueError as error:
                    raise ValueError(f"{name}: {error}") from None
        try:
            return cls.model_validate(values)
        except ValidationError as error:
            first = error.errors(include_url=False, include_context=False, include_input=False)[0]
            raise ValueError(": ".join([*(str(part) for part in first["loc"]), first["msg"]])) from None

    @classmethod
    def from_results(cls, results: Iterable[Result]) -> Self:
        """Read values from results, parameters or arguments; raises as `from_texts`."""
        return cls.from_texts({result.name: result.value for result in results})

    def texts(self) -> dict[str, str]:
        """Return the text of each value that is there, by name.

        Raises:
            ValueError: one has no text of its type, such as a number that is not finite.
        """
        return {
            name: _written(name, data.code, value)
            for name, data in self.data().items()
            if (value := getattr(self, name)) is not None
        }

    def named(self, kind: type[_Named]) -> tuple[_Named, ...]:
        """Return the values as `Result`, `Parameter` or `Argument`, in order; raises as `texts`."""
        texts, data = self.texts(), self.data()
        return tuple(kind(name=name, data_type_ref=data[name].code, value=text) for name, text in texts.items())


def type_code(annotation: Any) -> str:
    """Return the `data_type_ref` of a Python type.

    Raises:
        TypeError: values of this type have no text on the wire.
    """
    scalar, depth = _unwrapped(annotation)
    code = _CODES.get(scalar) or ("string" if _is_text(scalar) else "")
    if not code:
        raise TypeError(f"{annotation!r} has no data_type_ref")
    return code + "[]" * depth


def _is_text(scalar: Any) -> bool:
    if get_origin(scalar) is Literal:
        return all(isinstance(choice, str) for choice in get_args(scalar))
    return isinstance(scalar, type) and issubclass(scalar, StrEnum)


def _unwrapped(annotation: Any) -> tuple[Any, int]:
    """Return what an annotation is a list of, and how deep the list is; `| None` says nothing of either."""
    origin, arguments = get_origin(annotation), get_args(annotation)
    if origin is Annotated:
        return _unwrapped(arguments[0])
    if origin in (Union, UnionType):
        alternatives = [argument for argument in arguments if argument is not NoneType]
        if len(alternatives) == 1:
            return _unwrapped(alternatives[0])
    elif origin in (list, tuple) and arguments and arguments[1:] in ((), (Ellipsis,)):
        scalar, depth = _unwrapped(arguments[0])
        return scalar, depth + 1
    return annotation, 0


@cache
def _scalar_of(payload: type[Payload], name: str) -> Any:
    return _unwrapped(payload.model_fields[name].annotation)[0]


def _moments(value: Any) -> Any:
    return [_moments(item) for item in value] if isinstance(value, list) else read_date_time(value)


def _written(name: str, code: str, value: Any) -> str:
    try:
        return encode_value(code, value)
    except ValueError as error:
        raise ValueError(f"{name}: {error}") from None


@cache
def _data_of(payload: type[Payload]) -> Mapping[str, Data]:
    found: dict[str, Data] = {}
    for name, field in payload.model_fields.items():
        data = next((item for item in field.metadata if isinstance(item, Data)), Data(source="OpenRoIS"))
        try:
            found[name] = data if data.code else replace(data, code=type_code(field.annotation))
        except TypeError as error:
            raise TypeError(f"{payload.__name__}.{name}: {error}") from None
    return found


def _default(payload: type[Payload], name: str, code: str) -> str:
    field = payload.model_fields[name]
    if field.is_required() or (value := field.get_default(call_default_factory=True)) is None:
        return ""
    return _written(name, code, value)
