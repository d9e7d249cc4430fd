"""Params and results of `openrois.lease.*` and `openrois.stop_all`: leases, hand-over, resume, and STOP."""

from enum import StrEnum
from typing import Annotated, ClassVar, Final

from pydantic import Field

from openrois.types.messages import ReturnResult
from openrois.types.model import Model
from openrois.types.stops import StopId

__all__ = [
    "LEASES",
    "MAX_LOAN_MS",
    "MAX_RESUMED",
    "Lease",
    "LeaseBorrowParams",
    "LeaseChangedNotification",
    "LeaseDeclinedNotification",
    "LeaseParams",
    "LeaseRequestParams",
    "LeaseRequestResult",
    "LeaseRequestedNotification",
    "LeaseResult",
    "LeaseState",
    "LeaseStatus",
    "LeaseTokenResult",
    "LeaseWithdrawnNotification",
    "LoanEnd",
    "ResumeParams",
    "ResumeResult",
    "StopAllParams",
    "StopAllResult",
]

LEASES: Final = "openrois.lease"
"""The name of the extension in `openrois.hello`."""

MAX_RESUMED: Final = 1024
"""Commands that one session can ask about when it resumes another."""

MAX_LOAN_MS: Final = 600_000
"""Milliseconds for which a part can be taken at a time."""

_Token = Annotated[str, Field(max_length=256)]
_Epoch = Annotated[int, Field(ge=0)]
_Count = Annotated[int, Field(ge=0)]


class LeaseParams(Model):
    """Params of `openrois.lease.query`, `.request`, `.leave`, `.take` and `.give_back`."""

    component_ref: str


class LoanEnd(StrEnum):
    """What ends a loan, unless it is given back."""

    TIME = "TIME"
    """Its time."""
    COMMAND = "COMMAND"
    """The end of the first command `start` that the borrower has executed there; its time, if that comes first."""


class LeaseBorrowParams(Model):
    """Params of `openrois.lease.borrow`.

    Attributes:
        component_ref: the component; it is taken with its part.
        duration_ms: for which it is taken; what the gateway is configured for unless given.
        ends_with: what ends it.
    """

    component_ref: str
    duration_ms: Annotated[int, Field(ge=1, le=MAX_LOAN_MS)] | None = None
    ends_with: Annotated[LoanEnd, Field(strict=False)] = LoanEnd.TIME


class LeaseRequestParams(Model):
    """Params of `openrois.lease.grant` and `.decline`: the `request_id` of a request that the holder received."""

    request_id: str


class LeaseState(StrEnum):
    """The holder of a component, as the receiver sees it."""

    FREE = "FREE"
    """No application."""
    MINE = "MINE"
    """The receiver."""
    HELD = "HELD"
    """Another application."""
    ABSENT = "ABSENT"
    """Another application whose connection is lost, and which may come back."""


class LeaseStatus(Model):
    """The lease of one component, as the receiver sees it.

    Attributes:
        component_ref: the component.
        state: whether the receiver, another application or none holds it.
        holder: the subject of its holder; empty where it has none.
        epoch: grows with each new holder; 0 where it has none.
        waiting: how many wait for it.
        position: of the receiver among them, from 1 on; 0 where it does not wait.
        stopped_by: the person that has stopped its engine for programs; empty where none has.
        stop_id: of that STOP, for `openrois.lease.release_stop`.
        part: of the body, with which it changes hands; empty where it is one by itself.
        lender: the subject from which its holder has it for a time; empty where it has it in its own right.
        return_ms: until it goes back to that; 0 where it does not.
        return_position: of the receiver among those that it goes back to, the next one 1; 0 where it is none.
    """

    component_ref: str = ""
    state: Annotated[LeaseState, Field(strict=False)] = LeaseState.FREE
    holder: str = ""
    epoch: _Epoch = 0
    waiting: _Count = 0
    position: _Count = 0
    stopped_by: str = ""
    stop_id: str = ""
    part: str = ""
    lender: str = ""
    return_ms: _Count = 0
    return_position: _Count = 0


class LeaseResult(ReturnResult):
    """Result of `openrois.lease.query`, `.request`, `.borrow` and `.take`: the lease now."""

    lease: LeaseStatus | None = None


class LeaseRequestResult(LeaseResult):
    """Result of `openrois.lease.request`; `request_id` is empty where no holder has to be asked."""

    request_id: str = ""


class LeaseTokenResult(ReturnResult):
    """Result of `openrois.lease.token`: good once, for this subject, so long after a lost connection."""

    token: str = ""
    grace_ms: _Count = 0


class Lease(Model):
    """What a session holds."""

    component_ref: str
    epoch: _Epoch


class ResumeParams(Model):
    """Params of `openrois.lease.resume`; `command_ids` are the commands whose end is not known."""

    token: _Token
    command_ids: tuple[str, ...] = Field(default=(), max_length=MAX_RESUMED, strict=False)


class ResumeResult(LeaseTokenResult):
    """Result of `openrois.lease.resume`: the next token, what is held, and which commands are not known."""

    leases: tuple[Lease, ...] = Field(default=(), strict=False)
    forgotten: tuple[str, ...] = Field(default=(), strict=False)


class LeaseChangedNotification(LeaseStatus):
    """Params of the notification `openrois.lease.changed`; `reason` is one sentence for a person."""

    method: ClassVar[str] = "openrois.lease.changed"

    reason: str = ""


class LeaseRequestedNotification(Model):
    """Params of the notification `openrois.lease.requested` to the holder: `subject` asks, and waits so long."""

    method: ClassVar[str] = "openrois.lease.requested"

    component_ref: str
    request_id: str
    subject: str
    answer_ms: _Count


class LeaseDeclinedNotification(Model):
    """Params of `openrois.lease.declined` to the client that asked, which waits on unless the component is gone."""

    method: ClassVar[str] = "openrois.lease.declined"

    component_ref: str
    request_id: str
    reason: str


class LeaseWithdrawnNotification(Model):
    """Params of the notification `openrois.lease.withdrawn` to the holder: its answer is not needed any more."""

    method: ClassVar[str] = "openrois.lease.withdrawn"

    component_ref: str
    request_id: str


class StopAllParams(Model):
    """Params of `openrois.stop_all`: an engine, or the one of a component; without both all that one controls.

    Attributes:
        engine_id: the engine.
        component_ref: a component of the engine, in place of its id.
        stop_id: the same for the copies of one STOP that go several ways; the gateway makes one unless given.
    """

    engine_id: str | None = None
    component_ref: str | None = None
    stop_id: StopId | None = None


class StopAllResult(ReturnResult):
    """Result of `openrois.stop_all`: which components have stopped, and which have not confirmed it in time."""

    stopped: tuple[str, ...] = Field(default=(), strict=False)
    failed: tuple[str, ...] = Field(default=(), strict=False)
