"""The changes of leases carried out: notifications, and the end of what a former holder has left running."""

import asyncio
from collections.abc import Callable
from typing import Final

from openrois.aio.tasks import TaskScope
from openrois.auth.principal import Principal
from openrois.commands.pending import PendingCommands
from openrois.commands.stop import stop_components
from openrois.engine.engine import Engine
from openrois.leases.changes import Change, Gained, Lost, NotReturned, Queued, Why
from openrois.leases.lease_notifications import SENTENCES, Holder, LeaseNotifications, session_of
from openrois.leases.model import LeaseModel

__all__ = ["LeaseCarrier"]


def _ignore(_change: Change) -> None:
    """Stand in where changes are of no interest."""


_HANDED: Final = frozenset({Why.GRANTED, Why.TAKEN, Why.LENT, Why.DUE, Why.RETURNED})
"""Reasons with which what the former holder has begun is stopped before the new one can operate."""


class LeaseCarrier:
    """Carries out the changes of one engine's leases.

    Args:
        model: how things stand.
        engine: whose components are held.
        tasks: owns what goes on when a call has been answered.
        pending: the commands that end when their component is handed over.
        notifications: sends them.
        acted: records components that change hands without their new or former holder asking for it at that moment:
            whose, what, which component, and why.
        on_lost: called when a session does not hold a component any more.

    Attributes:
        ended: how many leases ended, by the reason.
        on_change: called with each change, in their order.
    """

    def __init__(
        self,
        model: LeaseModel,
        engine: Engine,
        tasks: TaskScope,
        pending: PendingCommands,
        notifications: LeaseNotifications,
        acted: Callable[[Principal, str, str, str], None],
        on_lost: Callable[[str, Holder], None],
    ) -> None:
        self.ended: dict[Why, int] = {}
        self.on_change: Callable[[Change], None] = _ignore
        self._model = model
        self._engine = engine
        self._tasks = tasks
        self._pending = pending
        self._notifications = notifications
        self._acted = acted
        self._on_lost = on_lost
        self._clearing: dict[str, asyncio.Task[None]] = {}

    def is_clearing(self, component_ref: str) -> bool:
        """Tell whether something of a former holder may run there yet."""
        return component_ref in self._clearing

    async def cleared(self, component_ref: str) -> None:
        """Wait until nothing of a former holder runs on the part of a component any more."""
        held = self._model.holding.held_of(self._model.holding.part_of(component_ref))
        clearing = {self._clearing[ref] for ref in held if ref in self._clearing}
        if clearing:
            # The hand-over goes on when the session that takes it is gone meanwhile.
            await asyncio.wait(clearing)

    def carry(self, changes: list[Change], answered: tuple[Holder, str] | None = None) -> None:
        """Carry out changes, and notify all sessions that they concern.

        Args:
            changes: in their order.
            answered: a session whose answer says what has become of one component: of that it is not notified; empty
                text for of none.
        """
        changed: dict[str, tuple[list[Holder], str]] = {}
        for change in changes:
            self.on_change(change)
            match change:
                case Lost(component_ref, holder, epoch, why):
                    self._lost(component_ref, session_of(holder), epoch, why)
                    changed[component_ref] = [session_of(holder)], SENTENCES[why]
                case Gained(component_ref, holder, epoch, why):
                    self._gained(component_ref, session_of(holder), epoch, why)
                    former, _ = changed.get(component_ref, ([], ""))
                    changed[component_ref] = former, SENTENCES[why]
                case NotReturned(component_ref, lender, epoch, why):
                    self._acted(
                        session_of(lender).principal, "lease.not_returned", component_ref, f"epoch {epoch}: {why}"
                    )
                    former, sentence = changed.get(component_ref, ([], SENTENCES[why]))
                    changed[component_ref] = [*former, session_of(lender)], sentence
                case Queued(component_ref):
                    changed.setdefault(component_ref, ([], ""))
                case _:
                    self._notifications.of_request(change)
        for component_ref, (former, sentence) in changed.items():
            but = answered[0] if answered is not None and answered[1] in ("", component_ref) else None
            # A new holder is told to all once it can operate; where none is left there is nothing to wait for.
            if component_ref not in self._clearing or self._model.holding.holder(component_ref) is None:
                self._notifications.to_all(component_ref, former, sentence, but=but)
            else:
                for each in former:
                    self._notifications.say(each, self._notifications.changed(component_ref, each, sentence))

    def _lost(self, component_ref: str, holder: Holder, epoch: int, why: Why) -> None:
        holder.bound.discard(component_ref)
        self.ended[why] = self.ended.get(why, 0) + 1
        if why is not Why.RELEASED:
            self._acted(holder.principal, "lease.lost", component_ref, f"epoch {epoch}: {why}")
        self._on_lost(component_ref, holder)
        if why is Why.RELEASED or why in _HANDED:
            self._notifications.adapter(component_ref, holder, epoch, holds=False)

    def _gained(self, component_ref: str, holder: Holder, epoch: int, why: Why) -> None:
        holder.bound.add(component_ref)
        if why is not Why.BOUND:
            self._acted(holder.principal, "lease.gained", component_ref, f"epoch {epoch}: {why}")
        if why not in _HANDED:
            self._notifications.adapter(component_ref, holder, epoch, holds=True)
            return
        before = self._clearing.get(component_ref)
        self._clearing[component_ref] = self._tasks.start(self._clear(component_ref, holder, why, before))

    async def _clear(self, component_ref: str, holder: Holder, why: Why, before: asyncio.Task[None] | None) -> None:
        """End what the former holder left running; then, and not before, the new one can operate."""
        try:
            if before is not None:
                await asyncio.wait({before})
            reason = f"{component_ref} is now held by {holder.principal.subject}: {SENTENCES[why]}"
            await stop_components(self._engine, self._pending, self._tasks, (component_ref,), reason)
        finally:
            if self._clearing.get(component_ref) is asyncio.current_task():
                del self._clearing[component_ref]
        held = self._model.holding.holder(component_ref)
        if held is not None and component_ref not in self._clearing:
            # It may have resumed meanwhile.
            self._notifications.adapter(component_ref, session_of(held[0]), held[1], holds=True)
            self._notifications.to_all(component_ref, (), SENTENCES[why])
