"""The component contract: the five methods of everything that an `Engine` can be made of.

`discover`, `query`, `invoke`, `subscribe`, `unsubscribe`. A registry of components in this process has them, so has
the proxy of an engine at the other end of a connection, and so has the engine itself. Rules that every implementation
keeps, checked by one contract suite:

* Methods return values or raise `RoISError`; an unknown component, command, query or event raises `Unsupported`.
* `invoke` returns when the command has ended, so it may take long; whoever calls it owns the task it runs in.
* `set_parameter` is a command and `get_parameter` a query, whatever the component.
* A `Sink` is called synchronously, must not block and must not raise. No event that happens once the component has
  taken the subscription is lost, even if it arrives before `subscribe` returns. After `unsubscribe` was called the sink
  is not called again.
* When a bus goes away every sink on it gets `SubscriptionLost` once, and everything that waits fails with
  `EngineUnreachable`.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Protocol, runtime_checkable

from openrois.event_text import EventText
from openrois.types.codes import ErrorType
from openrois.types.messages import Argument, Result
from openrois.types.profiles import HRIComponentProfile, HRIEngineProfile

__all__ = [
    "Client",
    "ComponentBus",
    "Directory",
    "Event",
    "Extension",
    "Fault",
    "FaultSource",
    "OnFault",
    "Sink",
    "SubscriptionLost",
    "ignore_fault",
]


@dataclass(frozen=True, slots=True)
class Directory:
    """What a bus offers: the engine's profile and the profile of every component in its tree, by component_ref."""

    profile: HRIEngineProfile
    component_profiles: Mapping[str, HRIComponentProfile] = field(default_factory=dict)


@dataclass(frozen=True)
class Event:
    """Something happened in a component. `expire` is the DateTime until which its details are kept, or empty."""

    event_id: str
    event_type: str
    component_ref: str
    expire: str
    results: tuple[Result, ...]

    @cached_property
    def text(self) -> EventText:
        """The event as it is told, the same for all who listen."""
        return EventText(self.event_id, self.event_type, self.expire, self.results)


@dataclass(frozen=True, slots=True)
class SubscriptionLost:
    """No more events will come."""

    reason: str


Sink = Callable[[Event | SubscriptionLost], None]
"""Takes the events of one subscription, in order."""


class ComponentBus(Protocol):
    """Components that can be found, asked, told and listened to."""

    async def discover(self) -> Directory:
        """Return what there is now."""
        ...

    async def query(self, component_ref: str, query_type: str) -> tuple[Result, ...]:
        """Ask a component."""
        ...

    async def invoke(
        self, component_ref: str, command_type: str, arguments: tuple[Argument, ...] = (), command_id: str = ""
    ) -> tuple[Result, ...]:
        """Tell a component to do something and wait until it is done.

        Args:
            component_ref: which component.
            command_type: what it is to do.
            arguments: of the command.
            command_id: what the application calls it; an engine behind a connection hears the same id where it is free.
        """
        ...

    async def subscribe(self, component_ref: str, event_type: str, sink: Sink) -> str:
        """Listen to one kind of event of a component and return the id that ends it."""
        ...

    async def unsubscribe(self, subscribe_id: str) -> None:
        """Stop listening; an unknown id is ignored."""
        ...


@dataclass(frozen=True, slots=True)
class Fault:
    """Something went wrong that is worth telling, whoever asked for it.

    Attributes:
        error_id: `<engine_id>/<rest>`, minted by the engine that noticed.
        error_type: of which kind.
        component_ref: whose fault it is; empty where it is the engine's itself.
        description: a sentence for a person.
        timestamp: DateTime when it was noticed.
    """

    error_id: str
    error_type: ErrorType
    component_ref: str
    description: str
    timestamp: str


OnFault = Callable[[Fault], None]
"""Takes the faults of a bus; must not block."""


def ignore_fault(_fault: Fault) -> None:
    """Stand in until the bus is attached: nobody could be told."""


@runtime_checkable
class FaultSource(Protocol):
    """What a bus has that can tell of faults: whoever it is attached to sets `on_fault`."""

    on_fault: OnFault


@dataclass(frozen=True, eq=False)
class Client:
    """The application that an extension call comes from, wherever it is, from its coming to its leaving.

    Identity decides: an application that left and came back, or comes over a new connection, is another `Client`, and
    what the former one has left behind is not its own.

    Attributes:
        client_id: opaque, unguessable.
        notify: sends the application a notification of an extension; must not block.
    """

    client_id: str
    notify: Callable[[str, Mapping[str, Any]], None]


class Extension(Protocol):
    """What a bus can do beyond the five methods: the streaming and signaling methods, which need to know who asks."""

    def engines(self) -> frozenset[str]:
        """Return the ids of the engines that can do it; others of the same bus have the five methods only."""
        ...

    async def call(self, method: str, params: Mapping[str, Any], client: Client) -> dict[str, Any]:
        """Ask and return the result, `return_code` included.

        Raises:
            RoISError: the call failed before any engine answered it.
        """
        ...

    async def forget(self, client: Client) -> None:
        """Say that a client is gone for good: its streams end. An unknown client is ignored."""
        ...
