"""Components that live in this process, under one engine id."""

import time
from collections import Counter
from collections.abc import Awaitable, Callable, Coroutine, Iterable
from dataclasses import dataclass
from typing import Any, Final

from openrois.aio.tasks import Deadline
from openrois.component.component import Component
from openrois.contract import Directory, Event, Extension, OnFault, Sink, ignore_fault
from openrois.engine.faults import FaultMint
from openrois.errors import BadParameter, OutOfResources, TimedOut, Unsupported
from openrois.types.codes import ErrorType
from openrois.types.messages import Argument, Result
from openrois.types.profiles import HRIEngineProfile, RoISIdentifier
from openrois.types.references import flaw_of_name, new_id, reference
from openrois.types.values import date_time

__all__ = ["LocalRegistry"]

EVENT_LIFETIME: Final = 60.0
"""Seconds for which an event's details are kept by the engines and clients that received it."""

MAX_QUERIES: Final = 32
"""Queries of one component that run at a time: one that hangs cannot use up its adapter's connection."""

QUERY_TIMEOUT: Final = 60.0
"""Seconds after which a query is cancelled: the caller has given up by then."""

_AT_ONCE: Final = ("component_status", "get_parameter")


Guard = Callable[[str, Component, str, Coroutine[Any, Any, tuple[Result, ...]]], Awaitable[tuple[Result, ...]]]
"""Runs a command: of which component, by reference and as an object, which, and what is to be awaited."""


async def _unguarded(
    _component_ref: str, _component: Component, _command_type: str, work: Coroutine[Any, Any, tuple[Result, ...]]
) -> tuple[Result, ...]:
    """Run a command to its end."""
    return await work


@dataclass(frozen=True, slots=True)
class _Subscription:
    component_ref: str
    event_type: str
    sink: Sink


class LocalRegistry:
    """The components of one engine; a `ComponentBus`.

    Args:
        engine_id: leads every component_ref.
        components: named by their profiles, each name once.
        extension: answers the streaming and signaling methods, where the engine has streams.
        wall_clock: epoch seconds, for the expiry of events.

    Attributes:
        guard: runs commands.

    Raises:
        BadParameter: `engine_id` or a component's name cannot be part of a reference, or a name stands twice.
        TypeError: a class stands where an instance of it should.
    """

    def __init__(
        self,
        engine_id: str,
        components: Iterable[Component],
        *,
        extension: Extension | None = None,
        wall_clock: Callable[[], float] = time.time,
    ) -> None:
        if flaw := flaw_of_name(engine_id):
            raise BadParameter(f"{engine_id!r} is no engine id: {flaw}")
        self.engine_id = engine_id
        self.extension = extension
        self.guard: Guard = _unguarded
        self.on_fault: OnFault = ignore_fault
        self._wall_clock = wall_clock
        self._mint = FaultMint(engine_id, wall_clock)
        self._components: dict[str, Component] = {}
        self._subscriptions: dict[str, _Subscription] = {}
        self._queries: Counter[str] = Counter()
        for component in components:
            self._add(component)

    def _add(self, component: Component) -> None:
        if isinstance(component, type):
            raise TypeError(f"{component.__name__} is a class: write {component.__name__}()")
        name = component.profile.name
        component_ref = reference(self.engine_id, name)
        if flaw := flaw_of_name(name) or ("it is taken" if component_ref in self._components else ""):
            raise BadParameter(f"{name!r} cannot name a component: {flaw}")
        self._components[component_ref] = component

        def emit(event_type: str, results: tuple[Result, ...]) -> None:
            self._emit(component_ref, event_type, results)

        def report(error_type: ErrorType, description: str) -> None:
            fault = self._mint.make(error_type, component_ref, description)
            if fault is not None:
                self.on_fault(fault)

        component.emit = emit
        component.report = report

    async def discover(self) -> Directory:
        """Return the engine's own components."""
        profile = HRIEngineProfile(
            identifier=RoISIdentifier(code=self.engine_id), component_ids=tuple(self._components)
        )
        return Directory(profile, {ref: component.profile for ref, component in self._components.items()})

    def _component(self, component_ref: str) -> Component:
        component = self._components.get(component_ref)
        if component is None:
            raise Unsupported(f"there is no component {component_ref!r}")
        return component

    async def query(self, component_ref: str, query_type: str) -> tuple[Result, ...]:
        """Query a component."""
        component = self._component(component_ref)
        if query_type in _AT_ONCE:
            return await component.ask(query_type)
        if self._queries[component_ref] >= MAX_QUERIES:
            raise OutOfResources(f"{component_ref} answers at most {MAX_QUERIES} queries at a time")
        self._queries[component_ref] += 1
        try:
            with Deadline(QUERY_TIMEOUT):
                return await component.ask(query_type)
        except TimeoutError:
            raise TimedOut(f"{component_ref} did not answer {query_type} in {QUERY_TIMEOUT:.0f} s") from None
        finally:
            self._queries[component_ref] -= 1

    async def invoke(
        self, component_ref: str, command_type: str, arguments: tuple[Argument, ...] = (), command_id: str = ""
    ) -> tuple[Result, ...]:
        """Run a command of a component to its end; in this process it needs no id."""
        component = self._component(component_ref)
        return await self.guard(component_ref, component, command_type, component.run(command_type, arguments))

    async def subscribe(self, component_ref: str, event_type: str, sink: Sink) -> str:
        """Subscribe to a component's event."""
        component = self._component(component_ref)
        if not component.profile.has_event(event_type):
            raise Unsupported(f"{component_ref} has no event {event_type!r}")
        component.require_usable(component_ref)
        subscribe_id = new_id(self.engine_id)
        self._subscriptions[subscribe_id] = _Subscription(component_ref, event_type, sink)
        component.subscribers_changed(event_type, len(self._sinks(component_ref, event_type)))
        return subscribe_id

    async def unsubscribe(self, subscribe_id: str) -> None:
        """End a subscription."""
        ended = self._subscriptions.pop(subscribe_id, None)
        if ended is not None:
            left = len(self._sinks(ended.component_ref, ended.event_type))
            self._component(ended.component_ref).subscribers_changed(ended.event_type, left)

    def _sinks(self, component_ref: str, event_type: str) -> list[Sink]:
        return [
            subscription.sink
            for subscription in self._subscriptions.values()
            if subscription.component_ref == component_ref and subscription.event_type == event_type
        ]

    def _emit(self, component_ref: str, event_type: str, results: tuple[Result, ...]) -> None:
        sinks = self._sinks(component_ref, event_type)
        if sinks:
            expire = date_time(self._wall_clock() + EVENT_LIFETIME)
            event = Event(new_id(self.engine_id), event_type, component_ref, expire, results)
            for sink in sinks:
                sink(event)
