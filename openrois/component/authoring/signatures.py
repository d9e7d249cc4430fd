"""From the signature of a method to payloads: parameters become arguments, a return annotation becomes results."""

import inspect
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from types import NoneType
from typing import Annotated, Any, Final, get_args, get_origin, get_type_hints

from pydantic import TypeAdapter, ValidationError, create_model

from openrois.catalog.payload import Data, Payload, type_code
from openrois.component.authoring.parameters import why

__all__ = [
    "Arguments",
    "Results",
    "first_sentence",
    "hints_of",
    "payload_of",
    "read_arguments",
    "read_results",
    "with_data",
]

_TYPES: Final = (
    "int, float, bool, str, datetime, ComponentStatus, an enumeration or Literal of texts, or a tuple of one of these"
)


@dataclass(frozen=True, slots=True)
class Results:
    """The results of a method.

    Attributes:
        payload: the results of its message; None for none.
        single: the name of the only result where the method returns the value itself; empty where it returns `payload`.
    """

    payload: type[Payload] | None = None
    single: str = ""

    def read(self, returned: object) -> Payload | None:
        """Return the value of a method's call as a payload.

        Raises:
            ValueError: it is something else than was declared.
        """
        if self.payload is None:
            if returned is not None:
                raise ValueError(f"it returned {returned!r} where None was declared")
            return None
        if self.single:
            return _validated(self.payload, {self.single: returned})
        if not isinstance(returned, self.payload):
            raise ValueError(f"it returned {returned!r} where a {self.payload.__name__} was declared")
        return _zoned(returned)


@dataclass(frozen=True, slots=True)
class Arguments:
    """The arguments of a method.

    Attributes:
        payload: the arguments of its message; None for none.
        signature: of the method, without `self`.
    """

    payload: type[Payload] | None
    signature: inspect.Signature

    def bind(self, values: tuple[object, ...], named: Mapping[str, object]) -> Payload | None:
        """Return the arguments of a call from within as a payload; a moment that is missing is now.

        Raises:
            TypeError: they are not those of the signature.
            ValueError: one is not of its type.
        """
        bound = self.signature.bind(*values, **named)
        bound.apply_defaults()
        if self.payload is None:
            return None
        given = {name: value for name, value in bound.arguments.items() if value is not None}
        for name, field in self.payload.model_fields.items():
            if name not in given and field.is_required() and field.annotation is datetime:
                given[name] = datetime.now(UTC)
        return _validated(self.payload, given)


def _validated(payload: type[Payload], values: Mapping[str, object]) -> Payload:
    try:
        return _zoned(payload.model_validate(values))
    except ValidationError as error:
        raise ValueError(why(error)) from None


def _zoned(payload: Payload) -> Payload:
    """Refuse a moment without time zone: another machine would read it in its own."""
    for name, value in payload:
        if isinstance(value, datetime) and value.tzinfo is None:
            raise ValueError(f"{name}: a moment needs a time zone, as in datetime.now(UTC)")
    return payload


def hints_of(place: str, function: Callable[..., Any]) -> dict[str, Any]:
    """Return the type hints of a function.

    Raises:
        TypeError: one names what is not there when the class is made.
    """
    try:
        return get_type_hints(function, include_extras=True)
    except NameError as error:
        raise TypeError(f"{place}: {error}; a type on the wire has to be known when the class is made") from None


def read_arguments(place: str, function: Callable[..., Any], name: str) -> Arguments:
    """Return the arguments of a method.

    Args:
        place: where it stands, for messages to its author.
        function: the method.
        name: of the payload's class.

    Raises:
        TypeError: a parameter has no type, or one that has no text on the wire.
    """
    hints = hints_of(place, function)
    signature = inspect.signature(function)
    _self, *parameters = signature.parameters.values()
    described = _described(inspect.getdoc(function) or "")
    fields: dict[str, Any] = {}
    for parameter in parameters:
        if parameter.kind not in (parameter.POSITIONAL_OR_KEYWORD, parameter.KEYWORD_ONLY):
            raise TypeError(f"{place}: {parameter} cannot stand on the wire; write each argument with its own name")
        if parameter.name not in hints:
            raise TypeError(f"{place}: write the type of {parameter.name}, such as `{parameter.name}: int`")
        default = ... if parameter.default is parameter.empty else parameter.default
        description = described.get(parameter.name, "")
        fields[parameter.name] = _field(place, parameter.name, hints[parameter.name], default, description)
    return Arguments(payload_of(place, name, fields), signature.replace(parameters=parameters))


def read_results(place: str, function: Callable[..., Any], single: str, name: str) -> Results:
    """Return the results of a method.

    Args:
        place: where it stands, for messages to its author.
        function: the method.
        single: the name of a single result.
        name: of the payload's class.

    Raises:
        TypeError: the return annotation is missing, or of a type that has no text on the wire.
    """
    hints = hints_of(place, function)
    if "return" not in hints:
        raise TypeError(f"{place}: write what it returns, `-> None` for nothing")
    annotation = hints["return"]
    if annotation in (None, NoneType):
        return Results()
    if isinstance(annotation, type) and issubclass(annotation, Payload):
        return Results(annotation)
    optional = type(None) in get_args(annotation)
    field = _field(place, single, annotation, None if optional else ..., "", ", or a Payload for several results")
    return Results(payload_of(place, name, {single: field}), single)


def payload_of(place: str, name: str, fields: Mapping[str, Any]) -> type[Payload] | None:
    """Return a payload made of fields as pydantic takes them, or None where there are none.

    Raises:
        TypeError: a default does not fit its type.
    """
    if not fields:
        return None
    payload: type[Payload] = create_model(name, __base__=Payload, __doc__="Made from a signature.", **dict(fields))
    for field, (annotation, default) in fields.items():
        if default is not ... and default is not None:
            try:
                TypeAdapter(annotation).validate_python(default)
            except ValidationError as error:
                raise TypeError(f"{place}: the default of {field}: {error.errors()[0]['msg']}") from None
    return payload


def _field(place: str, name: str, annotation: Any, default: Any, description: str, more: str = "") -> tuple[Any, Any]:
    if name.startswith("_") or hasattr(Payload, name):
        raise TypeError(f"{place}: {name!r} cannot be the name of a value; choose another")
    inner = get_args(annotation)[0] if get_origin(annotation) is Annotated else annotation
    try:
        type_code(inner)
    except TypeError:
        shown = getattr(annotation, "__name__", annotation)
        raise TypeError(f"{place}: {name}: {shown} has no text on the wire; write {_TYPES}{more}") from None
    return with_data(annotation, Data(description=description, source="OpenRoIS")), default


def with_data(annotation: Any, data: Data) -> Any:
    """Return an annotation that says `data` of its values; where it says something already, no more than read only."""
    if get_origin(annotation) is Annotated:
        inner, *more = get_args(annotation)
        said = next((each for each in more if isinstance(each, Data)), data)
        kept = [each for each in more if each is not said]
        return Annotated[(inner, *kept, replace(said, read_only=said.read_only or data.read_only))]
    return Annotated[annotation, data]


def first_sentence(documentation: str | None) -> str:
    """Return the first sentence of a docstring in one line; empty where there is none."""
    paragraph = " ".join(inspect.cleandoc(documentation or "").partition("\n\n")[0].split())
    found = re.match(r".+?[.!?](?= |$)", paragraph)
    return found[0] if found else paragraph


def _described(documentation: str) -> dict[str, str]:
    """Return what the `Args:` of a docstring says of each argument."""
    section = re.search(r"^Args:\n((?:[ \t]+.*\n?|\n)+)", documentation, re.MULTILINE)
    if section is None:
        return {}
    entries = re.findall(r"^(\w+)(?: \(.*?\))?: (.+(?:\n[ \t]+.+)*)", inspect.cleandoc(section[1]), re.MULTILINE)
    return {name: " ".join(text.split()).rstrip(".") for name, text in entries}
