"""Values of Python's types as texts of the wire and back, with errors that name what does not fit; conditions."""

from collections.abc import Iterable, Mapping
from typing import Any

from openrois.errors import BadParameter, ComponentFailed
from openrois.types.messages import Argument, Result
from openrois.types.profiles import ParameterProfile
from openrois.types.values import decode_value, encode_value

__all__ = ["read", "where", "write"]


def write(what: str, profiles: Iterable[ParameterProfile], values: Mapping[str, Any]) -> tuple[Argument, ...]:
    """Write values as the types of their profiles; None is not written.

    Args:
        what: takes them, for the message of an error.
        profiles: of the arguments or parameters that there are.
        values: by name.

    Raises:
        BadParameter: a name is unknown, or a value does not fit.
    """
    codes = {profile.name: profile.data_type_ref.code for profile in profiles}
    if unknown := values.keys() - codes:
        raise BadParameter(f"{what} takes no {', '.join(sorted(unknown))}; there are: {', '.join(codes) or 'none'}")
    return tuple(_write(what, name, codes[name], value) for name, value in values.items() if value is not None)


def _write(what: str, name: str, code: str, value: Any) -> Argument:
    try:
        return Argument(name=name, data_type_ref=code, value=encode_value(code, value))
    except ValueError as error:
        raise BadParameter(f"{what}: {name}: {error}") from None


def read(what: str, kind: Any, values: Iterable[Result]) -> Any:
    """Read values as a payload, or by name with the types that they carry.

    Args:
        what: gave them, for the message of an error.
        kind: the payload's class, or `dict`.
        values: as they came.

    Raises:
        ComponentFailed: one does not fit.
    """
    try:
        if kind is dict:
            return {each.name: decode_value(each.data_type_ref, each.value) for each in values}
        return kind.from_results(values)
    except ValueError as error:
        raise ComponentFailed(f"{what} returned a value that does not fit: {error}") from error


def where(**properties: str) -> str:
    """Return the condition that each property equals its text: `where(component_ref="robot/navigation")`.

    `component_ref` and `component_type` (a URN) are what a gateway knows. Conditions are joined by ` AND `.
    """
    return " AND ".join(f"{name} = '{text.replace(chr(39), chr(39) * 2)}'" for name, text in properties.items())
