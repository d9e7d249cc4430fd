"""Reads Pydantic models into definitions: their fields, constraints, defaults and docstrings. Pure."""

import inspect
import types
import typing
from collections.abc import Iterator, Mapping
from datetime import datetime
from enum import Enum
from typing import Annotated, Any, Final, Literal, get_args, get_origin

from annotated_types import Ge, Gt, Le, Lt, MaxLen, MinLen
from pydantic import AfterValidator, BaseModel, BeforeValidator, FailFast, Strict
from pydantic.fields import FieldInfo
from pydantic_core import to_jsonable_python

from openrois.catalog.payload import Data, Payload
from openrois_codegen.ir import (
    Definition,
    Enumeration,
    Field,
    Identity,
    Instant,
    Integer,
    ListOf,
    MapOf,
    Named,
    Number,
    Structure,
    Text,
    Truth,
    Type,
    Union,
)

__all__ = ["Reader"]

_PLAIN: Final[Mapping[Any, Type]] = {
    bool: Truth(),
    float: Number(),
    datetime: Instant(),
    str | int | float: Identity(),
}


class Reader:
    """Reads models, and with each the types it is made of.

    Args:
        names: the names and sentences of literals and unions of models, which have none of their own.

    Attributes:
        definitions: what was read, by name.
        sources: what each was read from: a model, an enumeration, a literal or a union.
    """

    def __init__(self, names: Mapping[Any, tuple[str, str]]) -> None:
        self._names = names
        self.definitions: dict[str, Definition] = {}
        self.sources: dict[str, Any] = {}

    def read(self, model: type[BaseModel]) -> str:
        """Read a model and return its name.

        Raises:
            TypeError: a field has a type that the wire does not.
        """
        name = model.__name__
        if name not in self.definitions:
            self.definitions[name] = Structure(name, _doc_of(model), ())  # a profile has profiles of its own kind
            wire_required = _extra(model.model_config).get("required", ())
            said = model.data() if issubclass(model, Payload) else {}
            fields = tuple(
                self._field(field_name, field, field_name in wire_required, said.get(field_name, Data()))
                for field_name, field in model.model_fields.items()
            )
            self.definitions[name] = Structure(name, _doc_of(model), fields)
            self.sources[name] = model
        return name

    def enumerations(self) -> dict[str, Enumeration]:
        """Return the enumerations among what was read."""
        return {name: found for name, found in self.definitions.items() if isinstance(found, Enumeration)}

    def _field(self, name: str, field: FieldInfo, wire_required: bool, data: Data) -> Field:
        found, nullable = self._nullable(field.annotation, _limits([*field.metadata, field]))
        required = field.is_required() or wire_required
        default = None if required else to_jsonable_python(field.get_default(call_default_factory=True))
        return Field(name, found, required, nullable, default, data.remark, data.code, data.read_only)

    def _nullable(self, annotation: Any, limits: Mapping[str, int]) -> tuple[Type, bool]:
        alternatives = _alternatives(annotation)
        others = [alternative for alternative in alternatives if alternative is not types.NoneType]
        if len(others) == len(alternatives):
            return self._type(annotation, limits), False
        if len(others) == 1:
            return self._type(others[0], limits), True
        if (found := _PLAIN.get(typing.Union[tuple(others)])) is not None:  # noqa: UP007 - of a list there is no other
            return found, True
        raise TypeError(f"{annotation!r}: null beside several types")

    def _type(self, annotation: Any, limits: Mapping[str, int]) -> Type:
        if get_origin(annotation) is Annotated:
            inner, *metadata = get_args(annotation)
            return self._type(inner, {**limits, **_limits(metadata)})
        if annotation in self._names:
            return self._aliased(annotation)
        if annotation is str:
            return Text(limits.get("min_length", 0), limits.get("max_length"))
        if annotation is int:
            return Integer(limits.get("minimum"), limits.get("maximum"))
        if annotation in _PLAIN:
            return _PLAIN[annotation]
        return self._composed(annotation, limits)

    def _composed(self, annotation: Any, limits: Mapping[str, int]) -> Type:
        origin, arguments = get_origin(annotation), get_args(annotation)
        if origin is tuple and arguments[1:] == (Ellipsis,):
            return ListOf(self._type(arguments[0], {}), limits.get("min_length", 0), limits.get("max_length"))
        if origin is dict and arguments[0] is str:
            return MapOf(self._type(arguments[1], {}))
        if inspect.isclass(annotation) and issubclass(annotation, BaseModel):
            return Named(self.read(annotation))
        if inspect.isclass(annotation) and issubclass(annotation, Enum):
            members = tuple(str(member.value) for member in annotation)
            return self._define(Enumeration(annotation.__name__, _doc_of(annotation), members), annotation)
        raise TypeError(f"{annotation!r} is no type of the wire")

    def _aliased(self, annotation: Any) -> Type:
        name, doc = self._names[annotation]
        if get_origin(annotation) is Literal:
            return self._define(Enumeration(name, doc, get_args(annotation)), annotation)
        members = tuple(self.read(member) for member in get_args(annotation))
        return self._define(Union(name, doc, members), annotation)

    def _define(self, definition: Definition, source: Any) -> Named:
        self.definitions[definition.name] = definition
        self.sources[definition.name] = source
        return Named(definition.name)


def _doc_of(owner: type) -> str:
    """Return a class's own docstring without indentation."""
    return inspect.cleandoc(owner.__doc__ or "")


def _alternatives(annotation: Any) -> tuple[Any, ...]:
    return get_args(annotation) if get_origin(annotation) in (typing.Union, types.UnionType) else (annotation,)


_KEYWORDS: Final = {
    "minLength": "min_length",
    "minItems": "min_length",
    "maxLength": "max_length",
    "maxItems": "max_length",
}

_LIMITS: Final[Mapping[type, tuple[str, str, int]]] = {
    Ge: ("minimum", "ge", 0),
    Gt: ("minimum", "gt", 1),
    Le: ("maximum", "le", 0),
    Lt: ("maximum", "lt", -1),
    MinLen: ("min_length", "min_length", 0),
    MaxLen: ("max_length", "max_length", 0),
}
"""Which limit each kind is, where its number stands, and how far the first that fits is from it."""

_NO_LIMITS: Final = (Strict, FailFast, AfterValidator, BeforeValidator, Data)


def _limits(metadata: list[Any]) -> dict[str, int]:
    return dict(pair for item in metadata for pair in _limits_of(item))


def _limits_of(item: Any) -> Iterator[tuple[str, int]]:
    if isinstance(item, FieldInfo):
        yield from _limits(item.metadata).items()
        yield from ((_KEYWORDS[keyword], limit) for keyword, limit in _extra(item).items())
    elif type(item) in _LIMITS:
        name, attribute, beyond = _LIMITS[type(item)]
        yield name, int(getattr(item, attribute)) + beyond
    elif not isinstance(item, _NO_LIMITS):
        raise TypeError(f"{item!r} is a limit that nothing is generated from yet")


def _extra(owner: Any) -> Mapping[str, Any]:
    """Return what a field or a model adds to its JSON schema by hand."""
    found = owner.get("json_schema_extra") if isinstance(owner, dict) else owner.json_schema_extra
    return found if isinstance(found, dict) else {}
