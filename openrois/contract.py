"""The component contract: the five methods of everything that an `Engine` can be made of. Pure.

`discover`, `query`, `invoke`, `subscribe`, `unsubscribe`. A registry of components in this process has them, so has
the proxy of an engine at the other end of a connection, and so has the engine itself. Rules that every implementation
keeps, checked by one contract suite:

* Methods return values or raise `RoISError`; an unknown component, command, query or event raises `Unsupported`.
* `invoke` returns when the command has ended, so it may take long; the caller owns the task it runs in.
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

from openrois.jsonrpc.protocol import decode, encode
from openrois.types.codes import ErrorType
from openrois.types.messages import Argument, Result
from openrois.types.profiles import HRIComponentProfile, HRIEngineProfile
from openrois.types.stops import StoppedNotification
from openrois.types.streams import HolderNotification

__all__ = [
    "Client",
    "ComponentBus",
    "Directory",
    "Event",
    "EventText",
    "Extension",
    "Fault",
    "FaultSource",
    "LatchKeeper",
    "OnFault",
    "Sink",
    "SubscriptionLost",
    "ignore_fault",
]


@dataclass(frozen=True, slots=True)
class Directory:
    """Offer of a bus: the engine's profile and the profile of every component in its tree, by component_ref."""

    profile: HRIEngineProfile
    component_profiles: Mapping[str, HRIComponentProfile] = field(default_factory=dict)


class EventText:
    """The params of `rois.event.notify_event` but for the id of a subscription.

    That is all that is kept of an event: its results as objects take three times as much memory.
    """

    __slots__ = ("_before", "_behind")

    def __init__(self, event_id: str, event_type: str, expire: str, results: tuple[Result, ...]) -> None:
        self._before = encode({"event_id": event_id, "event_type": event_type})[:-1] + ',"subscribe_id":'
        self._behind = "," + encode({"expire": expire, "results": results})[1:]

    def params_for(self, subscription: str) -> str:
        """Return the params for one subscription, whose id is given as JSON text."""
        return f"{self._before}{subscription}{self._behind}"

    def results(self) -> tuple[Result, ...]:
        """Return the results of the event."""
        return tuple(Result.model_validate(each) for each in decode("{" + self._behind[1:])["results"])


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
        """The params of the notification, the same for every subscriber."""
        return EventText(self.event_id, self.event_type, self.expire, self.results)


@dataclass(frozen=True, slots=True)
class SubscriptionLost:
    """No more events will come."""

    reason: str


Sink = Callable[[Event | SubscriptionLost], None]
"""Receives the events of one subscription, in order."""


class ComponentBus(Protocol):
    """Components that can be discovered, queried, commanded and subscribed to."""

    async def discover(self) -> Directory:
        """Return the profiles of the components that are there now.

        The profile of an engine below the bus's own that is the same object as in the directory before says that this
        engine, and all below it, have neither changed nor left since, nor have the profiles of their components.
        """
        ...

    async def query(self, component_ref: str, query_type: str) -> tuple[Result, ...]:
        """Query a component."""
        ...

    async def invoke(
        self, component_ref: str, command_type: str, arguments: tuple[Argument, ...] = (), command_id: str = ""
    ) -> tuple[Result, ...]:
        """Run a command of a component and wait until it is done.

        Args:
            component_ref: which component.
            command_type: what it is to do.
            arguments: of the command.
            command_id: the application's id for it; an engine behind a connection gets the same id where it is free.
        """
        ...

    async def subscribe(self, component_ref: str, event_type: str, sink: Sink) -> str:
        """Subscribe to one kind of event of a component and return the id that ends it."""
        ...

    async def unsubscribe(self, subscribe_id: str) -> None:
        """End a subscription; an unknown id is ignored."""
        ...


@dataclass(frozen=True, slots=True)
class Fault:
    """An error of an engine or a component that applications are notified of (notify_error; RoIS 2.0, 8.2).

    Attributes:
        error_id: `<engine_id>/<rest>`, minted by the engine that noticed.
        error_type: of which kind.
        component_ref: the component at fault; empty where it is the engine itself.
        description: a sentence for a person.
        timestamp: DateTime when it was noticed.
    """

    error_id: str
    error_type: ErrorType
    component_ref: str
    description: str
    timestamp: str


OnFault = Callable[[Fault], None]
"""Receives the faults of a bus; must not block."""


def ignore_fault(_fault: Fault) -> None:
    """Stand in until the bus is attached: there is nothing to notify yet."""


@runtime_checkable
class FaultSource(Protocol):
    """A bus that reports faults: the engine that it is attached to sets `on_fault`."""

    on_fault: OnFault


@runtime_checkable
class LatchKeeper(Protocol):
    """A bus whose engines keep by whom they were stopped, so that the next gateway knows it, too."""

    def keep_stop(self, notice: StoppedNotification) -> None:
        """Notify an engine that a person has stopped it, or has handed it back; must not block."""
        ...


@dataclass(frozen=True, eq=False)
class Client:
    """The application that an extension call comes from, directly or through engines, for as long as it is connected.

    Identity decides: an application that left and came back, or comes over a new connection, is another `Client`, and
    what the former one has left behind is not its own.

    Attributes:
        client_id: opaque, unguessable.
        notify: sends the application a notification of an extension; must not block.
    """

    client_id: str
    notify: Callable[[str, Mapping[str, Any]], None]


class Extension(Protocol):
    """Methods of a bus beside the five: streaming and signaling, where each call names its application.

    One with a true attribute `takes_role` tells visitors apart and keeps to their consent: it gets `role` beside
    the params of connect_stream. Others are not asked for what needs that.
    """

    def engines(self) -> frozenset[str]:
        """Return the ids of the engines that have these methods; others of the same bus have the five methods only."""
        ...

    async def call(self, method: str, params: Mapping[str, Any], client: Client) -> dict[str, Any]:
        """Call a method and return its result, `return_code` included.

        Raises:
            RoISError: the call failed before any engine answered it.
        """
        ...

    async def set_holder(self, notification: HolderNotification, client: Client) -> None:
        """Note whether a client holds a component from now on, or not any more.

        Raises:
            RoISError: no engine here takes that of the component.
        """
        ...

    async def forget_client(self, client: Client) -> None:
        """End what a client has: it is gone for good. An unknown client is ignored."""
        ...
