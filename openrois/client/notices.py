"""What a client tells its application of its own accord, beside events and completed commands."""

from dataclasses import dataclass, field
from typing import Any

from openrois.types.codes import ErrorType

__all__ = [
    "BindingLost",
    "BindingRestored",
    "Connected",
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
    """Something happened that concerns the whole client; `match` tells what."""


@dataclass(frozen=True, slots=True)
class Connected(Notice):
    """There is a connection again; bindings are made again, as far as they can be."""


@dataclass(frozen=True, slots=True)
class Disconnected(Notice):
    """The connection ended. Commands that ran are `ConnectionLost`; whether they go on is not known.

    Attributes:
        reason: one sentence.
        retry_in: seconds until the next attempt, or None when there will be none.
    """

    reason: str
    retry_in: float | None


@dataclass(frozen=True, slots=True)
class ProfileChanged(Notice):
    """The engines or components behind the gateway are others now."""


@dataclass(frozen=True, slots=True)
class Fault(Notice):
    """An engine or component reports an error (notify_error); `get_error_detail` says more."""

    error_id: str
    error_type: ErrorType


@dataclass(frozen=True, slots=True)
class BindingLost(Notice):
    """A component that was bound is not any more: it is gone, or another application has it by now.

    It is bound again as soon as it can be, unless it is released.
    """

    component_ref: str
    error: Exception


@dataclass(frozen=True, slots=True)
class BindingRestored(Notice):
    """A component is bound again. What runs there was not started by this connection."""

    component_ref: str


@dataclass(frozen=True, slots=True)
class SubscriptionLost(Notice):
    """A subscription could not be made again: its component is gone, or does not work. It is tried again."""

    event_type: str
    condition: str
    error: Exception


@dataclass(frozen=True, slots=True)
class SubscriptionRestored(Notice):
    """A subscription is made again; what happened in between was not heard."""

    event_type: str
    condition: str


@dataclass(frozen=True, slots=True)
class Notification:
    """A notification as it came, also one of an extension."""

    method: str
    params: dict[str, Any] = field(default_factory=dict)
