"""Changes that follow from an operation on leases, in the order in which they are notified. Pure."""

from dataclasses import dataclass
from enum import StrEnum

from openrois.leases.waiting import Request

__all__ = ["Asked", "Change", "Declined", "Gained", "Lost", "NotReturned", "Queued", "Why", "Withdrawn"]


class Why(StrEnum):
    """Reason why a component has another holder, or none."""

    BOUND = "bound"
    RELEASED = "released"
    GRANTED = "granted"
    TAKEN = "taken"
    RESUMED = "resumed"
    """Its holder has gone on over another connection, before the old one was known to be lost."""
    EXPIRED = "expired"
    """The holder's connection was lost, and it did not come back in time."""
    LEFT = "left"
    """The holder has left the engine, or its connection was lost and nothing says that it comes back."""
    GONE = "gone"
    """The component itself is gone."""
    LENT = "lent"
    """It was taken for a time by a session of higher rank."""
    DUE = "due"
    """The time for which it was lent is over."""
    RETURNED = "returned"
    """It has come back to the session from which it was taken for a time."""
    LATCHED = "latched"
    """It would have come back, and may not be operated by that session now: STOP."""


@dataclass(frozen=True, slots=True)
class Lost:
    """A component is held no more. `epoch` is the one that is over; `on_loan` says whether it was for a time only."""

    component_ref: str
    holder: object
    epoch: int
    why: Why
    on_loan: bool = False


@dataclass(frozen=True, slots=True)
class Gained:
    """An application holds a component from now on; `on_loan` says whether for a time only."""

    component_ref: str
    holder: object
    epoch: int
    why: Why
    on_loan: bool = False


@dataclass(frozen=True, slots=True)
class Asked:
    """The holder has to be asked."""

    request: Request
    holder: object


@dataclass(frozen=True, slots=True)
class Declined:
    """The holder has declined, or not answered in time.

    The place in the queue stays, unless the component is `gone` or there is a `problem`, a sentence, that lets no
    session have it now.
    """

    request: Request
    in_time: bool
    gone: bool = False
    problem: str = ""


@dataclass(frozen=True, slots=True)
class Withdrawn:
    """A request that the holder was asked about was withdrawn."""

    request: Request
    holder: object


@dataclass(frozen=True, slots=True)
class Queued:
    """Applications that wait for the component may have another place in the queue now."""

    component_ref: str


@dataclass(frozen=True, slots=True)
class NotReturned:
    """A component that was taken for a time from a session in an epoch does not come back to it."""

    component_ref: str
    lender: object
    epoch: int
    why: Why


Change = Lost | Gained | NotReturned | Asked | Declined | Withdrawn | Queued
