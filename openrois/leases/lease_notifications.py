"""Notifications of leases: to sessions the lease as each sees it, to adapters the holder of a component."""

import asyncio
import logging
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from typing import Any, Final, Protocol, cast

from openrois.aio.tasks import TaskScope
from openrois.auth.principal import Principal
from openrois.auth.ranks import Ranks
from openrois.commands.stop_latch import StopLatch
from openrois.contract import Client
from openrois.engine.engine import Engine
from openrois.errors import RoISError
from openrois.leases.changes import Asked, Declined, Why, Withdrawn
from openrois.leases.model import LeaseModel
from openrois.leases.parts import name_of
from openrois.types.leases import (
    LeaseChangedNotification,
    LeaseDeclinedNotification,
    LeaseRequestedNotification,
    LeaseState,
    LeaseStatus,
    LeaseWithdrawnNotification,
)
from openrois.types.references import engine_of
from openrois.types.stops import StoppedNotification
from openrois.types.streams import HolderNotification

__all__ = [
    "SENTENCES",
    "Holder",
    "LeaseNotifications",
    "notify_holder",
    "session_of",
]

_log = logging.getLogger(__name__)

SENTENCES: Final[Mapping[Why, str]] = {
    Why.BOUND: "it was free",
    Why.RELEASED: "it was given back",
    Why.GRANTED: "its holder has handed it over",
    Why.TAKEN: "an administrator has taken it",
    Why.RESUMED: "its holder has gone on over another connection",
    Why.EXPIRED: "its holder's connection was lost and did not come back in time",
    Why.LEFT: "its holder has left",
    Why.GONE: "the component is gone",
    Why.LENT: "an application of higher rank has taken it for a time",
    Why.DUE: "the time for which it was taken is over",
    Why.RETURNED: "it has come back to the application from which it was taken for a time",
    Why.LATCHED: "it does not come back: STOP holds for this application",
}


class Holder(Protocol):
    """A session that may hold components. Identity decides.

    Attributes:
        principal: of the application.
        client: it, as adapters know it.
        leasing: whether it knows of leases, and wants their notifications.
        bound: what it has bound.
    """

    principal: Principal
    client: Client
    leasing: bool
    bound: set[str]

    def send_notification(self, method: str, params: Mapping[str, Any]) -> None:
        """Send the application a notification; must not block."""
        ...


class LeaseNotifications:
    """Sends the notifications of the leases of one engine.

    Args:
        model: how things stand.
        engine: its adapters are notified.
        tasks: owns what goes on when a call has been answered.
        now: monotonic seconds.
        latch: which engines are stopped for programs.
        ranks: tell which holders are programs.
    """

    def __init__(
        self,
        model: LeaseModel,
        engine: Engine,
        tasks: TaskScope,
        now: Callable[[], float],
        latch: StopLatch,
        ranks: Ranks,
    ) -> None:
        self._model = model
        self._engine = engine
        self._tasks = tasks
        self._now = now
        self._latch = latch
        self._ranks = ranks
        self._watchers: dict[str, set[Holder]] = {}

    def status(self, component_ref: str, viewer: Holder) -> LeaseStatus:
        """Return the lease of a component, as one session sees it."""
        held = self._model.holding.holder(component_ref)
        part = self._model.holding.part_of(component_ref)
        always: dict[str, Any] = {
            "component_ref": component_ref,
            "part": name_of(part),
            "stopped_by": self._latch.by(engine_of(component_ref)),
            "stop_id": self._latch.stop_id(engine_of(component_ref)),
        }
        # To others a component is not free of which the part is held.
        holder = self._model.holding.holder_of(part)
        if holder is None or (held is None and holder is viewer):
            return LeaseStatus(**always)
        return LeaseStatus(
            **always,
            state=self._state(holder, viewer),
            holder=session_of(holder).principal.subject,
            epoch=0 if held is None else held[1],
            **self._of_part(part, viewer),
        )

    def _of_part(self, part: str, viewer: Holder) -> dict[str, Any]:
        """Return what a status says of the queue and of the loan of a part."""
        askers = [request.asker for request in self._model.waiting.queue(part)]
        lenders = [lender.holder for lender in reversed(self._model.loans.lenders(part))]
        loan = self._model.loans.of(part)
        return {
            "waiting": len(askers),
            "position": _place(viewer, askers),
            "lender": session_of(lenders[0]).principal.subject if lenders else "",
            "return_position": _place(viewer, lenders),
            "return_ms": 0 if loan is None else max(0, round((loan.until - self._now()) * 1000)),
        }

    def _state(self, holder: object, viewer: Holder) -> LeaseState:
        if holder is viewer:
            return LeaseState.MINE
        return LeaseState.ABSENT if holder in self._model.absent else LeaseState.HELD

    def watch(self, component_ref: str, viewer: Holder) -> None:
        """Notify a session from now on, until it leaves, when a component has another holder."""
        self._watchers.setdefault(component_ref, set()).add(viewer)

    def adapter(self, component_ref: str, holder: Holder, epoch: int, *, holds: bool) -> None:
        """Notify the adapter of a component whether a session holds it; a program holds nothing that is stopped."""
        if holds and self._latch.by(engine_of(component_ref)) and self._ranks.is_program(holder.principal):
            return
        notice = HolderNotification(component_ref=component_ref, holds=holds, epoch=epoch)
        self._tasks.start(notify_holder(self._engine, notice, holder.client))

    def of_request(self, change: Asked | Declined | Withdrawn) -> None:
        """Notify the holder, or the session that asks, what became of a request."""
        request = change.request
        named = {"component_ref": request.component_ref, "request_id": request.request_id}
        match change:
            case Asked(_, holder):
                left = max(0.0, (request.deadline or 0.0) - self._now())
                subject = session_of(request.asker).principal.subject
                asked = LeaseRequestedNotification(**named, subject=subject, answer_ms=round(left * 1000))
                self.say(session_of(holder), asked)
            case Declined(_, in_time, gone, problem):
                answer = "its holder keeps it" if in_time else "its holder did not answer in time"
                reason = SENTENCES[Why.GONE] if gone else problem or answer
                self.say(session_of(request.asker), LeaseDeclinedNotification(**named, reason=reason))
            case Withdrawn(_, holder):
                self.say(session_of(holder), LeaseWithdrawnNotification(**named))

    def to_all(self, component_ref: str, former: Collection[Holder], reason: str, *, but: Holder | None = None) -> None:
        """Notify every session concerned of the lease of a component."""
        concerned = self._concerned(component_ref) | set(former)
        for viewer in concerned - {but}:
            self.say(viewer, self.changed(component_ref, viewer, reason))

    def of_stop(self, notice: StoppedNotification, component_refs: Iterable[str]) -> None:
        """Notify every session that holds, waits for or watches one of an engine's components of a STOP."""
        concerned = {viewer for ref in component_refs for viewer in self._concerned(ref) if self._hears(viewer, ref)}
        for viewer in concerned:
            self._send(viewer, notice)

    def _concerned(self, component_ref: str) -> set[Holder]:
        held = self._model.holding.holder(component_ref)
        part = self._model.holding.part_of(component_ref)
        queue, lenders = self._model.waiting.queue(part), self._model.loans.lenders(part)
        concerned = set(self._watchers.get(component_ref, ()))
        concerned |= {session_of(request.asker) for request in queue if request.component_ref == component_ref}
        concerned |= {session_of(lender.holder) for lender in lenders if component_ref in lender.epochs}
        return concerned if held is None else concerned | {session_of(held[0])}

    def changed(self, component_ref: str, viewer: Holder, reason: str) -> LeaseChangedNotification:
        """Return the notification of another holder or another queue for one session."""
        status = self.status(component_ref, viewer)
        return LeaseChangedNotification(**status.model_dump(), reason=reason)

    def say(self, viewer: Holder, notice: "_Told") -> None:
        """Notify a session, if it wants notifications of extensions, after the answer to its request."""
        if self._hears(viewer, notice.component_ref):
            self._send(viewer, notice)

    def _hears(self, viewer: Holder, component_ref: str) -> bool:
        return viewer.leasing and viewer.principal.sees(component_ref)

    def _send(self, viewer: Holder, notice: "_Told | StoppedNotification") -> None:
        # The reply to the request leaves first.
        params = notice.model_dump(mode="json")
        asyncio.get_running_loop().call_soon(viewer.send_notification, notice.method, params)

    def forget_watcher(self, viewer: Holder) -> None:
        """Stop notifying a session of what it only watches."""
        for component_ref in [ref for ref, viewers in self._watchers.items() if viewer in viewers]:
            self._watchers[component_ref].discard(viewer)
            if not self._watchers[component_ref]:
                del self._watchers[component_ref]


def _place(viewer: object, line: Sequence[object]) -> int:
    """Return the place of a session in a line, the first one 1; 0 where it is not there."""
    return next((place for place, each in enumerate(line, 1) if each is viewer), 0)


_Told = LeaseChangedNotification | LeaseRequestedNotification | LeaseDeclinedNotification | LeaseWithdrawnNotification


def session_of(holder: object) -> Holder:
    """Return a holder of the model, which takes any object for one, as the session that it is."""
    return cast(Holder, holder)


async def notify_holder(engine: Engine, notice: HolderNotification, client: Client) -> None:
    """Notify the engine of a component whether `client` holds it; an engine that refuses that is left alone."""
    try:
        await engine.extension.set_holder(notice, client)
    except RoISError as error:
        _log.debug("%s is not told who holds it: %s", notice.component_ref, error)
