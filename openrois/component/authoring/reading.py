"""From a component class to its type: which methods are messages, what they carry, and whether the standard agrees."""

import inspect
import re
import sys
from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any, Final, Literal, get_type_hints

from openrois.catalog.common import ROIS_COMMON
from openrois.catalog.component_type import CommandType, ComponentType, EventType, QueryType
from openrois.catalog.payload import Data, Payload, type_code
from openrois.component.authoring.marks import Mark, mark_of
from openrois.component.authoring.parameters import NoParameters, ParameterField
from openrois.component.authoring.signatures import (
    Arguments,
    Results,
    first_sentence,
    hints_of,
    payload_of,
    read_arguments,
    read_results,
    with_data,
)
from openrois.types.codes import ComponentFunction

__all__ = ["AuthoredType", "Message", "own_type", "read_class"]

_EVERYBODYS: Final = ("set_parameter", "get_parameter")
_COMMON: Final = frozenset(
    [command.name for command in ROIS_COMMON.commands] + [query.name for query in ROIS_COMMON.queries]
)
_Kind = Literal["command", "query", "event"]


@dataclass(frozen=True, slots=True)
class Message:
    """A message and the method behind it.

    Attributes:
        name: on the wire.
        attribute: the method's name.
        arguments: what the method takes.
        results: what it returns; of an event, what it tells.
    """

    name: str
    attribute: str
    description: str
    arguments: Arguments
    results: Results
    timeout: int | None = None

    def command_type(self) -> CommandType:
        """Return the command's type."""
        return CommandType(
            self.name, self.description, self.arguments.payload, self.results.payload, timeout=self.timeout
        )

    def query_type(self) -> QueryType:
        """Return the query's type."""
        return QueryType(self.name, self.description, self.results.payload or NoParameters)

    def event_type(self) -> EventType:
        """Return the event's type."""
        return EventType(self.name, self.description, self.arguments.payload or NoParameters)


@dataclass(frozen=True, slots=True)
class AuthoredType:
    """Declarations of a component class.

    Attributes:
        component_type: the type, with what the class implements of it.
        commands, queries: by their names on the wire.
        events: by the names of their methods.
        parameters: their names, types and defaults.
    """

    component_type: ComponentType
    commands: Mapping[str, Message]
    queries: Mapping[str, Message]
    events: Mapping[str, Message]
    parameters: type[Payload]


def read_class(cls: type, kind: ComponentType, reserved: Collection[str], omit: Collection[str]) -> AuthoredType:
    """Read a component class.

    Args:
        cls: the class.
        kind: its type; messages of its own need not stand there.
        reserved: attributes that no message or parameter may be called by.
        omit: events and parameters of the type that the class does without.

    Raises:
        TypeError: the class says something that cannot be on the wire, or that its type says otherwise; the text says
            what to write.
    """
    reader = _Reader(cls, kind, frozenset(reserved))
    _check_omitted(cls, kind, omit)
    commands = reader.messages("command")
    queries = reader.messages("query")
    events = {name: message for name, message in reader.messages("event").items() if name not in omit}
    parameters = reader.parameters(omit)
    implemented = _implemented(kind, commands, queries, events, parameters)
    by_attribute = {message.attribute: message for message in events.values()}
    return AuthoredType(implemented, commands, queries, by_attribute, parameters or NoParameters)


def _implemented(
    kind: ComponentType,
    commands: Mapping[str, Message],
    queries: Mapping[str, Message],
    events: Mapping[str, Message],
    parameters: type[Payload] | None,
) -> ComponentType:
    """Return the type with what is there of it: `component_status` is always, where the type has RoIS_Common."""
    command_types = [message.command_type() for message in commands.values()]
    query_types = [message.query_type() for message in queries.values()]
    common = replace(ROIS_COMMON, commands=tuple(each for each in command_types if each.name in _COMMON))
    shared = ROIS_COMMON in kind.includes
    return replace(
        kind,
        commands=tuple(each for each in command_types if not (shared and each.name in _COMMON)),
        queries=tuple(each for each in query_types if not (shared and each.name in _COMMON)),
        events=tuple(message.event_type() for message in events.values()),
        parameters=parameters,
        includes=(common,) if shared else (),
    )


def _check_omitted(cls: type, kind: ComponentType, omit: Collection[str]) -> None:
    """Raise TypeError where something is left out that is not there, or that the type requires."""
    data = {} if kind.parameters is None else kind.parameters.data()
    events = {event.name for event in kind.all_events()}
    for name in omit:
        if name not in data and name not in events:
            raise TypeError(f"{cls.__name__} omits {name!r}, which {kind.code} has not")
        if name in data and data[name].obligation == "M":
            raise TypeError(f"{cls.__name__} omits {name!r}, which {kind.code} requires")


class _Reader:
    """Reads one class; `kind` says what the names that it has in common with its type mean."""

    def __init__(self, cls: type, kind: ComponentType, reserved: frozenset[str]) -> None:
        self._cls = cls
        self._kind = kind
        self._reserved = reserved

    def messages(self, kind: _Kind) -> dict[str, Message]:
        """Return the messages of one kind that are implemented: those of RoIS_Common first, then the type's order."""
        found: dict[str, Message] = {}
        for attribute, function, mark in self._marked(kind):
            name = mark.name or attribute
            place = f"{self._cls.__qualname__}.{attribute}"
            self._check_name(place, kind, attribute, name)
            if name in found:
                raise TypeError(f"{place}: {found[name].attribute} is the {kind} {name!r} already; choose another name")
            found[name] = self._message(place, attribute, function, replace(mark, name=name))
        order = {message.name: index for index, message in enumerate(self._standard(kind))}
        return dict(sorted(found.items(), key=lambda item: order.get(item[0], len(order))))

    def _marked(self, kind: _Kind) -> Iterator[tuple[str, Callable[..., Any], Mark]]:
        """Yield the attributes that are messages; a method that overrides one is the same message."""
        marks: dict[str, Mark] = {}
        for base in reversed(self._cls.__mro__):
            for attribute, value in vars(base).items():
                mark = mark_of(value)
                if mark is not None:
                    marks[attribute] = mark
                elif attribute in marks:
                    marks[attribute] = self._overridden(base, attribute, value, marks[attribute])
        for attribute, mark in marks.items():
            if mark.kind == kind and not mark.optional:
                yield attribute, inspect.unwrap(getattr(self._cls, attribute)), mark

    def _overridden(self, base: type, attribute: str, value: object, mark: Mark) -> Mark:
        place = f"{base.__qualname__}.{attribute}"
        if mark.kind == "event":
            raise TypeError(f"{place} overrides an event: write `@event` above it")
        if not inspect.iscoroutinefunction(value):
            raise TypeError(f"{place} overrides a {mark.kind}: write `async def {attribute}`")
        return replace(mark, optional=False)

    def _check_name(self, place: str, kind: _Kind, attribute: str, name: str) -> None:
        if attribute in self._reserved:
            raise TypeError(
                f"{place}: every component has a {attribute!r} of its own; give the method another name and write "
                f"`@{kind}(name={name!r})`"
            )
        if name in _EVERYBODYS:
            raise TypeError(f"{place}: every component has {name!r}; write `name: type = parameter(default)` instead")
        if "/" in name:
            raise TypeError(f"{place}: {name!r} cannot be the name of a message: it has a slash")

    def _standard(self, kind: _Kind) -> tuple[CommandType | QueryType | EventType, ...]:
        if kind == "command":
            return (*ROIS_COMMON.commands, *self._kind.all_commands())
        return self._kind.all_queries() if kind == "query" else self._kind.all_events()

    def _message(self, place: str, attribute: str, function: Callable[..., Any], mark: Mark) -> Message:
        label = f"{self._cls.__name__}{''.join(word.title() for word in mark.name.split('_'))}"
        arguments = read_arguments(place, function, f"{label}Arguments")
        if mark.kind == "event":
            if hints_of(place, function).get("return", None) not in (None, type(None)):
                raise TypeError(f"{place}: announcing an event gives nothing back; write `-> None`")
            results = Results()
        else:
            results = read_results(place, function, mark.result or mark.name, f"{label}Results")
        if mark.kind == "query" and arguments.payload is not None:
            raise TypeError(f"{place}: a query takes no arguments; write a command, or parameters that it looks at")
        description = first_sentence(function.__doc__)
        read = Message(mark.name, attribute, description, arguments, results, mark.timeout)
        standard = next((message for message in self._standard(mark.kind) if message.name == mark.name), None)
        return read if standard is None else _fitted(place, read, standard)

    def parameters(self, omit: Collection[str]) -> type[Payload] | None:
        """Return the parameters as a payload, or None where there are none."""
        fields: dict[str, Any] = {}
        for base in reversed(self._cls.__mro__):
            for name, value in vars(base).items():
                if not isinstance(value, ParameterField):
                    if name in fields:
                        raise TypeError(f"{base.__qualname__}.{name} overrides a parameter: write `parameter(...)`")
                    continue
                fields[name] = self._parameter(base, name, value)
        place = f"{self._cls.__qualname__} (parameters)"
        kept = {name: field for name, field in fields.items() if name not in omit}
        return payload_of(place, f"{self._cls.__name__}Parameters", kept)

    def _parameter(self, base: type, name: str, field: ParameterField) -> tuple[Any, Any]:
        place = f"{base.__qualname__}.{name}"
        if name in self._reserved or name.startswith("_") or hasattr(Payload, name):
            raise TypeError(f"{place}: {name!r} cannot be the name of a parameter; choose another")
        annotation = _annotation(base, name, place)
        try:
            code = type_code(annotation)
        except TypeError:
            raise TypeError(f"{place}: {annotation} has no text on the wire") from None
        if code.endswith("[]") and "list[" in str(annotation):
            raise TypeError(f"{place}: write `tuple[..., ...]`: a list could be changed unnoticed")
        data = Data(description=field.description, source="OpenRoIS", read_only=field.read_only)
        standard = self._kind.parameters
        if standard is not None and name in standard.model_fields:
            expected = type_code(standard.model_fields[name].annotation)
            if code != expected:
                raise TypeError(f"{place}: in {self._kind.code} it is of type {expected}, not {code}")
            said = standard.data()[name]
            data = replace(said, read_only=said.read_only or field.read_only)
        return with_data(annotation, data), field.default


def _annotation(base: type, name: str, place: str) -> Any:
    written = inspect.get_annotations(base)
    if name not in written:
        raise TypeError(f"{place}: write its type, such as `{name}: int = parameter(...)`")
    holder = type(base.__name__, (), {"__annotations__": {name: written[name]}, "__module__": base.__module__})
    # A class that is made from text is of a module that is nowhere.
    known = getattr(sys.modules.get(base.__module__), "__dict__", {})
    try:
        return get_type_hints(holder, known, dict(vars(base)), include_extras=True)[name]
    except NameError as error:
        raise TypeError(f"{place}: {error}; its type has to be known when the class is made") from None


def _fitted(place: str, read: Message, standard: CommandType | QueryType | EventType) -> Message:
    """Return a message as the standard has it, with the author's method behind it."""
    if isinstance(standard, EventType):
        _check_fields(place, standard.name, read.arguments.payload, standard.results)
        return replace(read, arguments=replace(read.arguments, payload=standard.results))
    arguments = standard.arguments if isinstance(standard, CommandType) else None
    _check_fields(place, standard.name, read.arguments.payload, arguments)
    results = Results(standard.results)
    if read.results.single and standard.results is not None:
        names = tuple(standard.results.model_fields)
        if len(names) != 1:
            raise TypeError(f"{place}: write `-> {standard.results.__name__}`, which has {', '.join(names)}")
        results = Results(standard.results, names[0])
        single = read.results.payload.model_fields[read.results.single] if read.results.payload else None
        expected = type_code(standard.results.model_fields[names[0]].annotation)
        if single is None or type_code(single.annotation) != expected:
            raise TypeError(f"{place}: {standard.name} returns a value of type {expected}")
    elif read.results.payload is not standard.results:
        shown = "None" if standard.results is None else standard.results.__name__
        raise TypeError(f"{place}: write `-> {shown}`, which is what {standard.name} returns")
    timeout = read.timeout if read.timeout is not None or not isinstance(standard, CommandType) else standard.timeout
    return replace(
        read,
        arguments=replace(read.arguments, payload=arguments),
        results=results,
        timeout=timeout,
    )


def _check_fields(place: str, name: str, found: type[Payload] | None, expected: type[Payload] | None) -> None:
    codes = _codes(found)
    wanted = _codes(expected)
    if codes != wanted:
        shown = ", ".join(f"{name}: {code}" for name, code in wanted.items()) or "nothing"
        raise TypeError(f"{place}: the standard's {name} takes {shown}")


def _codes(payload: type[Payload] | None) -> dict[str, str]:
    fields = {} if payload is None else payload.model_fields
    return {name: type_code(field.annotation) for name, field in fields.items()}


def own_type(
    cls: type, base: ComponentType | None, code: str, authority: str, function: str | None, part: str | None
) -> ComponentType:
    """Return the type that a class is of before its messages are known.

    Args:
        cls: the class.
        base: the type of the class that it extends, or None where it is the first.
        code: of the type; empty for the base's, or the name of the class.
        authority: defines the type; empty for the base's.
        function: its class in the ontology; None for the base's.
        part: of the body; empty for none, None for the base's.
    """
    chosen = ComponentFunction(function) if function is not None else base.function if base is not None else None
    inherited = base.part if base is not None and chosen is base.function else ""
    moved = inherited if part is None else part
    if moved and chosen is not ComponentFunction.ACTUATION:
        raise TypeError(f"{cls.__name__} is of the part {moved!r} of a body, and so it has to be an actuation")
    if base is not None and not code and not authority:
        own = replace(base, function=chosen, part=moved)
        return base if own == base else own
    name = code or cls.__name__
    return ComponentType(
        code=name,
        name=re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", name).lower(),
        description=first_sentence(cls.__doc__),
        source=cls.__module__,
        function=chosen,
        part=moved,
        includes=(ROIS_COMMON,),
        authority=authority or (base.authority if base is not None else "local"),
    )
