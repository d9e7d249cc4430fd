"""Notices of a client to its application, beside events and completed commands."""

from dataclasses import dataclass, field
from typing import Any

from openrois.types.codes import ErrorType
from openrois.types.leases import LeaseState

__all__ = [
    "BindingLent",
    "BindingLost",
    "BindingRestored",
    "BodyLost",
    "Connected",
    "ControlChanged",
    "ControlDeclined",
    "ControlRequested",
    "ControlStopped",
    "ControlWithdrawn",
    "Disconnected",
    "Fault",
    "Notice",
    "Notification",
    "ProfileChanged",
    "SubscriptionLost",
    "SubscriptionRestored",
]


@dataclass(frozen=True, slots=True)
class Notice:
    """A notice that concerns the whole client; `match` tells which."""


@dataclass(frozen=True, slots=True)
class Connected(Notice):
    """There is a connection again; bindings are made again, as far as they can be."""


@dataclass(frozen=True, slots=True)
class Disconnected(Notice):
    """The connection ended. Running commands are reported after it was made again in time, or are `ConnectionLost`.

    Attributes:
        reason: one sentence.
        retry_in: seconds until the next attempt, or None when there will be none.
    """

    reason: str
    retry_in: float | None


@dataclass(frozen=True, slots=True)
class ProfileChanged(Notice):
    """The engines or components behind the gateway have changed.

    Attributes:
        engine_ids: which; empty where the gateway does not say, or there are too many.
    """

    engine_ids: frozenset[str] = frozenset()


@dataclass(frozen=True, slots=True)
class Fault(Notice):
    """An engine or component reports an error (notify_error; RoIS 2.0, 8.2); `Client.get_error_detail` says more.

    Attributes:
        error_id: what `get_error_detail` takes.
        error_type: what kind of error it is.
    """

    error_id: str
    error_type: ErrorType


@dataclass(frozen=True, slots=True)
class BindingLost(Notice):
    """A component that was bound is not any more: it is gone, or another application has it by now.

    It is bound again as soon as it can be, unless it is released, or was handed over or taken.

    Attributes:
        component_ref: the component.
        error: why, as the operation that found out would have raised it.
    """

    component_ref: str
    error: Exception


@dataclass(frozen=True, slots=True)
class BindingLent(Notice):
    """An application of higher rank has taken a component that was bound; it comes back: `BindingRestored`.

    What ran there ends with ABORT, and commands are refused meanwhile. If it does not come back `BindingLost` follows.

    Attributes:
        component_ref: the component.
        holder: the subject of the application that has it.
        seconds: after which it comes back at the latest, unless it is taken for longer.
    """

    component_ref: str
    holder: str
    seconds: float


@dataclass(frozen=True, slots=True)
class BindingRestored(Notice):
    """A component is bound again. This connection started none of the commands that run there.

    Attributes:
        component_ref: the component.
    """

    component_ref: str


@dataclass(frozen=True, slots=True)
class BodyLost(Notice):
    """A body that was reserved is not any more, because a required part of it is lost; the other parts were released.

    It is not reserved again: leave the block of `Client.body`, and enter another one.

    Attributes:
        engine_id: the engine that the body is.
        component_ref: the part that was lost; empty where the client has no connection any more.
        error: why, as the operation that found out would have raised it.
    """

    engine_id: str
    component_ref: str
    error: Exception


@dataclass(frozen=True, slots=True)
class ControlChanged(Notice):
    """A component has another holder, or another queue; see `Control.status` and docs/explanation/control.md.

    Attributes:
        component_ref: the component.
        state: whether this application, another one or none holds it.
        holder: the subject of its holder.
        waiting: how many wait for it.
        position: of this application among them, from 1 on; 0 where it does not wait.
        reason: one sentence.
        part: of the body, with which it changes hands; empty where it is one by itself.
        lender: the subject from which its holder has it for a time; empty where it has it in its own right.
        return_in: seconds until it goes back to that; 0 where it does not.
        return_position: of this application among those that it goes back to, the next one 1; 0 where it is none.
    """

    component_ref: str
    state: LeaseState
    holder: str
    waiting: int
    position: int
    reason: str
    part: str = ""
    lender: str = ""
    return_in: float = 0.0
    return_position: int = 0


@dataclass(frozen=True, slots=True)
class ControlRequested(Notice):
    """Another application requests a component that this one holds: `client.control.grant` or `decline` answers.

    Attributes:
        component_ref: the component.
        request_id: what is answered.
        subject: the subject of the application that requests it.
        within: seconds after which no answer is a no.
    """

    component_ref: str
    request_id: str
    subject: str
    within: float


@dataclass(frozen=True, slots=True)
class ControlDeclined(Notice):
    """The holder keeps a component that this application has requested.

    Attributes:
        component_ref: the component.
        request_id: of the request that is answered so.
        reason: one sentence.
    """

    component_ref: str
    request_id: str
    reason: str


@dataclass(frozen=True, slots=True)
class ControlStopped(Notice):
    """A person has stopped a body, so that programs have to wait, or has handed it back to them.

    Attributes:
        engine_id: the body.
        by: the person that has stopped it; empty once it is handed back.
        reason: one sentence.
        stop_id: of the STOP, or of the one that was ended; another one with each STOP.
    """

    engine_id: str
    by: str
    reason: str
    stop_id: str = ""


@dataclass(frozen=True, slots=True)
class ControlWithdrawn(Notice):
    """Another application has withdrawn its request for a component.

    Attributes:
        component_ref: the component.
        request_id: of a `ControlRequested`; to answer it is too late.
    """

    component_ref: str
    request_id: str


@dataclass(frozen=True, slots=True)
class SubscriptionLost(Notice):
    """A subscription could not be made again: its component is gone, or does not work. It is tried again.

    Attributes:
        event_type: of what it is a subscription.
        condition: the components that it is to, as it was given.
        error: why, as `subscribe` would have raised it.
    """

    event_type: str
    condition: str
    error: Exception


@dataclass(frozen=True, slots=True)
class SubscriptionRestored(Notice):
    """A subscription is made again; events in between are missing.

    Attributes:
        event_type: of what it is a subscription.
        condition: the components that it is to, as it was given.
    """

    event_type: str
    condition: str


@dataclass(frozen=True, slots=True)
class Notification:
    """A notification as it came, also one of an extension.

    Attributes:
        method: such as `"signaling.offer"`.
        params: its members, as JSON values.
    """

    method: str
    params: dict[str, Any] = field(default_factory=dict)
