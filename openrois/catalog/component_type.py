"""Component types: what all components of a kind understand, and the profiles that follow from it."""

from collections.abc import Iterator
from dataclasses import dataclass

from openrois.catalog.payload import Payload
from openrois.types.codes import ComponentFunction
from openrois.types.profiles import (
    CommandMessageProfile,
    EventMessageProfile,
    HRIComponentProfile,
    ParameterProfile,
    QueryMessageProfile,
    RoISIdentifier,
    component_urn,
)

__all__ = ["CommandType", "ComponentType", "EventType", "QueryType"]


@dataclass(frozen=True, slots=True)
class CommandType:
    """A command: what it takes, what `get_command_result` gives, and the milliseconds it may take."""

    name: str
    description: str
    arguments: type[Payload] | None = None
    results: type[Payload] | None = None
    timeout: int | None = None

    def profile(self) -> CommandMessageProfile:
        """Return the command's profile."""
        return CommandMessageProfile(
            name=self.name,
            results=_profiles(self.results),
            arguments=_profiles(self.arguments),
            timeout=self.timeout,
        )


@dataclass(frozen=True, slots=True)
class QueryType:
    """A query and what it answers. It takes no arguments: the schema has no place for them."""

    name: str
    description: str
    results: type[Payload]

    def profile(self) -> QueryMessageProfile:
        """Return the query's profile."""
        return QueryMessageProfile(name=self.name, results=_profiles(self.results))


@dataclass(frozen=True, slots=True)
class EventType:
    """An event and what it tells. It takes no arguments either."""

    name: str
    description: str
    results: type[Payload]

    def profile(self) -> EventMessageProfile:
        """Return the event's profile."""
        return EventMessageProfile(name=self.name, results=_profiles(self.results))


@dataclass(frozen=True, slots=True)
class ComponentType:
    """A kind of component.

    Attributes:
        code: the type's name, e.g. `Navigation`.
        name: what the standard calls an instance, e.g. `navigation` (gml:name).
        description: one sentence.
        source: the file that defines it.
        function: its class in the ontology; an actuation has to be bound before it is operated.
        part: of the body that it is or moves; one application holds all of a part, or nothing of it.
        commands, queries, events: its own messages, without those of the types it includes.
        parameters: of the component.
        includes: the types whose messages it has as well.
        authority: who defines it.
        spelled_urn: its URN, where that is not formed of authority and code as it should be.
    """

    code: str
    name: str
    description: str
    source: str
    function: ComponentFunction | None = None
    commands: tuple[CommandType, ...] = ()
    queries: tuple[QueryType, ...] = ()
    events: tuple[EventType, ...] = ()
    parameters: type[Payload] | None = None
    includes: tuple["ComponentType", ...] = ()
    authority: str = "OMG"
    spelled_urn: str = ""
    part: str = ""

    @property
    def urn(self) -> str:
        """The type's identifier in profiles and conditions."""
        return self.spelled_urn or component_urn(self.code, self.authority)

    def all_commands(self) -> tuple[CommandType, ...]:
        """Return the commands of the type and of all it includes, the included ones first."""
        return (*(command for included in self.includes for command in included.all_commands()), *self.commands)

    def all_queries(self) -> tuple[QueryType, ...]:
        """Return the queries of the type and of all it includes, the included ones first."""
        return (*(query for included in self.includes for query in included.all_queries()), *self.queries)

    def all_events(self) -> tuple[EventType, ...]:
        """Return the events of the type and of all it includes, the included ones first."""
        return (*(event for included in self.includes for event in included.all_events()), *self.events)

    def required_commands(self) -> tuple[str, ...]:
        """Return the commands without which no component of the type can be used.

        What acts or senses has to be started and stopped, streams to be connected and disconnected; to pause is left to
        each component.
        """
        acts_or_senses = self.function in (ComponentFunction.ACTUATION, ComponentFunction.SENSING)
        needed = ("start", "stop") if acts_or_senses else ("connect_stream", "disconnect_stream")
        return tuple(each.name for each in self.all_commands() if each.name in needed)

    def payloads(self) -> Iterator[type[Payload]]:
        """Yield every payload of the type's own messages and parameters."""
        found = (
            *(payload for command in self.commands for payload in (command.arguments, command.results)),
            *(query.results for query in self.queries),
            *(event.results for event in self.events),
            self.parameters,
        )
        yield from (payload for payload in found if payload is not None)

    def profile(self, name: str = "") -> HRIComponentProfile:
        """Return the profile of an instance that does all of it; one that does less lists less.

        Args:
            name: of the instance; the standard's unless given.
        """
        return self._profile(
            name or self.name, (), commands=self.all_commands(), queries=self.all_queries(), events=self.all_events()
        )

    def definition(self) -> HRIComponentProfile:
        """Return the profile of the type itself, as the standard writes it: what it includes is named, not listed."""
        included = tuple(each.urn for each in self.includes)
        return self._profile(self.name, included, commands=self.commands, queries=self.queries, events=self.events)

    def _profile(
        self,
        name: str,
        included: tuple[str, ...],
        *,
        commands: tuple[CommandType, ...],
        queries: tuple[QueryType, ...],
        events: tuple[EventType, ...],
    ) -> HRIComponentProfile:
        return HRIComponentProfile(
            identifier=RoISIdentifier(code=self.spelled_urn or self.code, authority=self.authority),
            name=name,
            function=self.function,
            part=self.part or None,
            sub_component_profiles=included,
            command_profiles=tuple(command.profile() for command in commands),
            query_profiles=tuple(query.profile() for query in queries),
            event_profiles=tuple(event.profile() for event in events),
            parameter_profiles=_profiles(self.parameters),
        )


def _profiles(payload: type[Payload] | None) -> tuple[ParameterProfile, ...]:
    return () if payload is None else payload.profiles()
