"""Parameters of a component: typed attributes on one side, a store that `set_parameter` fills on the other."""

from collections.abc import Callable, Iterator, Mapping
from typing import Any, Protocol, Self, TypeVar, cast, overload

from pydantic import ValidationError

from openrois.catalog.payload import Payload
from openrois.errors import BadParameter
from openrois.types.messages import Argument, Parameter
from openrois.types.profiles import ParameterProfile
from openrois.types.values import check_value

__all__ = [
    "NoParameters",
    "ParameterField",
    "ParameterStore",
    "check_arguments",
    "parameter",
    "why",
]

_T = TypeVar("_T")


def parameter(default: _T, *, description: str = "", read_only: bool = False) -> _T:
    """Make an attribute of the class a parameter of the component.

        volume: int = parameter(50)

    Reading and setting the attribute reads and sets what applications see. `Annotated` limits its values, as in
    `Annotated[int, Field(ge=0, le=100)]`; `set_parameter` refuses others, and setting the attribute raises ValueError.

    Args:
        default: the value it has in the beginning; None for none, where its type allows that.
        description: a sentence for the profile.
        read_only: whether the component alone may set it.
    """
    # What stands in the class is the descriptor; type checkers see the attribute it stands for.
    return cast(_T, ParameterField(default, description, read_only))


class _HasStore(Protocol):
    @property
    def parameters(self) -> "ParameterStore": ...


class ParameterField:
    """The descriptor behind `parameter`: the attribute is an entry of the instance's store."""

    def __init__(self, default: object, description: str, read_only: bool) -> None:
        self.default = default
        self.description = description
        self.read_only = read_only
        self.name = ""

    def __set_name__(self, owner: type, name: str) -> None:
        self.name = name

    @overload
    def __get__(self, instance: None, owner: type) -> Self: ...
    @overload
    def __get__(self, instance: _HasStore, owner: type) -> Any: ...
    def __get__(self, instance: _HasStore | None, owner: type) -> Any:
        return self if instance is None else instance.parameters[self.name]

    def __set__(self, instance: _HasStore, value: object) -> None:
        instance.parameters[self.name] = value


class ParameterStore(Mapping[str, Any]):
    """The parameters of one instance by name, in the order of the profile; each always fits its type.

    Args:
        payload: their names, types and defaults.
    """

    def __init__(self, payload: type[Payload]) -> None:
        self._payload = payload
        self._values = dict(payload())
        self._written: dict[str, str] = {}

    def __getitem__(self, name: str) -> Any:
        return self._values[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._values)

    def __len__(self) -> int:
        return len(self._values)

    def __setitem__(self, name: str, value: object) -> None:
        self.update({name: value})

    def update(self, changes: Mapping[str, object], written: Mapping[str, str] | None = None) -> None:
        """Store values, all or none.

        Args:
            changes: the values by name.
            written: the texts that they were read from, to be returned as they came.

        Raises:
            KeyError: there is no such parameter.
            ValueError: one is not of its type.
        """
        for name in changes:
            self._values[name]
        try:
            checked = dict(self._payload.model_validate({**self._values, **changes}))
        except ValidationError as error:
            raise ValueError(why(error)) from None
        for name in changes:
            self._values[name] = checked[name]
            self._written.pop(name, None)
        self._written.update(written or {})

    def set_texts(self, texts: Mapping[str, str], accept: Callable[[dict[str, Any]], dict[str, Any]]) -> None:
        """Store what an application sets, all or none.

        Args:
            texts: the values by name.
            accept: gets them as values of their types, and returns what to store.

        Raises:
            ValueError: one is not of its type, or read only.
            KeyError, TypeError: what `accept` returned are no parameters.
        """
        data = self._payload.data()
        for name in texts:
            if data[name].read_only:
                raise ValueError(f"{name} is read-only")
        payload = self._payload.from_texts(texts)
        wanted = {name: getattr(payload, name) for name in texts}
        accepted = accept(dict(wanted))
        if not isinstance(accepted, dict):
            raise TypeError(f"accept_parameters returned {accepted!r}: return what to store")
        as_they_came = {name: text for name, text in texts.items() if accepted.get(name) == wanted[name]}
        self.update(accepted, as_they_came)

    def told(self) -> tuple[Parameter, ...]:
        """Return the parameters that have a value, as `get_parameter` answers them."""
        stored = self._payload.model_construct(**self._values).named(Parameter)
        told = (p.model_copy(update={"value": self._written.get(p.name, p.value)}) for p in stored)
        return tuple(parameter for parameter in told if parameter.value)


class NoParameters(Payload):
    """Stands for the parameters of a component that has none."""


def why(error: ValidationError) -> str:
    """Return the first problem in one line."""
    first = error.errors(include_url=False, include_context=False, include_input=False)[0]
    return f"{'.'.join(str(part) for part in first['loc'])}: {first['msg']}"


def check_arguments(profiles: tuple[ParameterProfile, ...], arguments: tuple[Argument, ...]) -> dict[str, str]:
    """Return the arguments' values by name; each keeps the type of the profile, whatever type the client wrote.

    Raises:
        BadParameter: a name is unknown or repeated, or a value does not fit.
    """
    types = {profile.name: profile.data_type_ref.code for profile in profiles}
    values: dict[str, str] = {}
    for argument in arguments:
        if argument.name not in types:
            raise BadParameter(f"nothing here is called {argument.name!r}; there are: {', '.join(types) or 'none'}")
        if argument.name in values:
            raise BadParameter(f"{argument.name!r} is given twice")
        try:
            check_value(types[argument.name], argument.value)
        except ValueError as error:
            raise BadParameter(f"{argument.name}: {error}") from None
        values[argument.name] = argument.value
    return values
