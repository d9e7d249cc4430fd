"""Leases at work: the rules with a clock, told to sessions and adapters, and the end of a former holder's commands."""

import asyncio
import time
from collections.abc import Awaitable, Callable, Iterable
from typing import Final

from openrois.aio.tasks import TaskScope
from openrois.auth.principal import Principal
from openrois.commands.pending import PendingCommands
from openrois.commands.stop import stop_components
from openrois.engine.engine import Engine
from openrois.leases.alarm import Alarm
from openrois.leases.changes import Change, Gained, Lost, Queued, Why
from openrois.leases.lease_notifications import SENTENCES, Holder, LeaseNotifications, session_of
from openrois.leases.model import LeaseModel, Replayed, Rules

__all__ = ["LeaseKeeper"]

_HANDED: Final = frozenset({Why.GRANTED, Why.TAKEN})


class LeaseKeeper:
    """Keeps the leases of one engine.

    Args:
        engine: whose components are held.
        tasks: owns what goes on when a call has been answered.
        accepted: the commands that end when their component is handed over.
        rules: how long what lasts.
        first_epoch: the number of the first epoch; greater than all that a former process of this gateway gave.
        clock: monotonic seconds.
        sleep: waits for some seconds.
        acted: hears of components that change hands without their new or former holder asking for it at that moment:
            whose, what, which component, and why.
        on_lost: is told when somebody does not hold a component any more.

    Attributes:
        model: the rules, and how things stand.
        telling: tells of it.
        ended: how many leases ended, by the reason.
    """

    def __init__(
        self,
        engine: Engine,
        tasks: TaskScope,
        accepted: PendingCommands,
        *,
        rules: Rules | None = None,
        first_epoch: int = 1,
        clock: Callable[[], float] = time.monotonic,
        sleep: Callable[[float], Awaitable[None]] = asyncio.sleep,
        acted: Callable[[Principal, str, str, str], None] = lambda _who, _method, _component_ref, _detail: None,
        on_lost: Callable[[str, Holder], None] = lambda _component_ref, _holder: None,
    ) -> None:
        self.ended: dict[Why, int] = {}
        self._acted = acted
        self._on_lost = on_lost
        self.model = LeaseModel(rules, first_epoch)
        self._engine = engine
        self._tasks = tasks
        self._accepted = accepted
        self.telling = LeaseNotifications(self.model, engine, tasks, clock)
        self._clearing: dict[str, asyncio.Task[None]] = {}
        self._alarm = Alarm(self._advance, tasks, clock, sleep)
        self._now = clock

    def is_held(self, component_ref: str, holder: Holder) -> bool:
        """Tell whether `holder` holds the component, and nothing of a former holder runs there any more."""
        return self.model.holding.is_held(component_ref, holder) and component_ref not in self._clearing

    def is_held_by_another(self, component_ref: str, holder: Holder) -> bool:
        """Tell whether somebody holds the component who is not `holder`."""
        return self.model.holding.is_held_by_another(component_ref, holder)

    def bind(self, component_ref: str, holder: Holder) -> int:
        """Reserve a component and return the epoch; its adapter is told, also when `holder` has it already.

        Raises:
            OutOfResources: somebody else holds it.
        """
        is_new = self.model.holding.holder(component_ref) is None
        epoch = self.model.holding.bind(component_ref, holder)
        if is_new:
            self._carry([Gained(component_ref, holder, epoch, Why.BOUND)], by=holder)
        else:
            self.telling.adapter(component_ref, holder, epoch, holds=True)
        return epoch

    def release(self, component_ref: str, holder: Holder) -> None:
        """Give a component back, if `holder` has it: the first in line has it next."""
        self._carry(self.model.release(component_ref, holder, self._now()), by=holder)

    def leave(self, holder: Holder) -> None:
        """Give everything back, and wait for nothing more. The adapters learn that from whoever forgets the client."""
        self.telling.forget(holder)
        self._carry(self.model.leave(holder, self._now()))

    def lose(self, holder: Holder) -> None:
        """Learn that a connection was lost: what a session with a resume token holds is kept for the grace."""
        self.telling.forget(holder)
        self._carry(self.model.lose(holder, self._now()))

    def keep_only(self, component_refs: Iterable[str]) -> None:
        """End the leases of components that are no longer there."""
        self._carry(self.model.keep_only(component_refs))

    def request(self, component_ref: str, asker: Holder) -> str:
        """Ask for a component; return the id of the request, or empty text where nobody has to be asked.

        Raises:
            OutOfResources: too many wait for it.
        """
        self._carry(self.model.request(component_ref, asker, self._now()), by=asker)
        request = self.model.waiting.find(component_ref, asker)
        return "" if request is None else request.request_id

    def withdraw(self, component_ref: str, asker: Holder) -> None:
        """Wait for a component no more."""
        self._carry(self.model.withdraw(component_ref, asker), by=asker)

    def waited_for(self, asker: Holder) -> list[str]:
        """Return the components that somebody waits for."""
        return [request.component_ref for request in self.model.waiting.of(asker)]

    def grant(self, request_id: str, holder: Holder) -> str:
        """Let who asks have the component, once what runs there has been stopped; return which it is.

        Raises:
            Unsupported: `holder` was not asked that.
        """
        changes = self.model.grant(request_id, holder, self._now())
        self._carry(changes)
        return next((change.component_ref for change in changes if isinstance(change, Gained)), "")

    def decline(self, request_id: str, holder: Holder) -> None:
        """Keep the component.

        Raises:
            Unsupported: `holder` was not asked that.
        """
        self._carry(self.model.decline(request_id, holder))

    async def take(self, component_ref: str, taker: Holder) -> None:
        """Have a component, whoever holds it, once what runs there has been stopped."""
        self._carry(self.model.take(component_ref, taker, self._now()))
        clearing = self._clearing.get(component_ref)
        if clearing is not None:
            # It goes on when whoever takes it is gone meanwhile.
            await asyncio.wait({clearing})

    def token(self, holder: Holder) -> str:
        """Return what the session is resumed with when its connection is lost.

        Raises:
            Unsupported: leases do not survive a connection here.
        """
        return self.model.token(holder, holder.principal.subject)

    def resume(self, token: str, successor: Holder) -> object:
        """Let a session go on in the place of another; return that one. Adapters are told who holds what now.

        Raises:
            Replayed: the token comes a second time.
            Unsupported: the token is not valid, or not for this subject.
        """
        subject = successor.principal.subject
        try:
            former, changes = self.model.resume(token, subject, successor, self._now())
        except Replayed as replayed:
            self._carry(replayed.changes)
            raise
        begun = {change.component_ref for change in changes if isinstance(change, Gained)}
        for component_ref, epoch in self.model.holding.held_by(successor).items():
            successor.bound.add(component_ref)
            if component_ref not in begun:
                self.telling.adapter(component_ref, successor, epoch, holds=True)
        self._carry(changes, by=successor)
        return former

    # How it is done.

    def _carry(self, changes: list[Change], by: Holder | None = None) -> None:
        """Carry out what follows from an operation, and tell everybody of it but whom its answer tells."""
        told: dict[str, tuple[Holder | None, str]] = {}
        for change in changes:
            match change:
                case Lost(component_ref, holder, epoch, why):
                    self._lost(component_ref, session_of(holder), epoch, why)
                    told[component_ref] = session_of(holder), SENTENCES[why]
                case Gained(component_ref, holder, epoch, why):
                    self._gained(component_ref, session_of(holder), epoch, why)
                    former, _ = told.get(component_ref, (None, ""))
                    told[component_ref] = former, SENTENCES[why]
                case Queued(component_ref):
                    told.setdefault(component_ref, (None, ""))
                case _:
                    self.telling.of_request(change)
        for component_ref, (former, sentence) in told.items():
            if component_ref not in self._clearing:
                self.telling.to_all(component_ref, former, sentence, but=by)
            elif former is not None:
                self.telling.say(former, self.telling.changed(component_ref, former, sentence))
        self._alarm.set(self.model.next_due())

    def _lost(self, component_ref: str, holder: Holder, epoch: int, why: Why) -> None:
        holder.bound.discard(component_ref)
        self.ended[why] = self.ended.get(why, 0) + 1
        if why is not Why.RELEASED:
            self._acted(holder.principal, "lease.lost", component_ref, f"epoch {epoch}: {why}")
        self._on_lost(component_ref, holder)
        if why is Why.RELEASED or why in _HANDED:
            self.telling.adapter(component_ref, holder, epoch, holds=False)

    def _gained(self, component_ref: str, holder: Holder, epoch: int, why: Why) -> None:
        holder.bound.add(component_ref)
        if why is not Why.BOUND:
            self._acted(holder.principal, "lease.gained", component_ref, f"epoch {epoch}: {why}")
        if why not in _HANDED:
            self.telling.adapter(component_ref, holder, epoch, holds=True)
            return
        before = self._clearing.get(component_ref)
        self._clearing[component_ref] = self._tasks.start(self._clear(component_ref, holder, why, before))

    async def _clear(self, component_ref: str, holder: Holder, why: Why, before: asyncio.Task[None] | None) -> None:
        """End what the former holder left running; then, and not before, the new one can operate."""
        try:
            if before is not None:
                await asyncio.wait({before})
            reason = f"{component_ref} is {holder.principal.subject}'s now: {SENTENCES[why]}"
            await stop_components(self._engine, self._accepted, self._tasks, (component_ref,), reason)
        finally:
            if self._clearing.get(component_ref) is asyncio.current_task():
                del self._clearing[component_ref]
        held = self.model.holding.holder(component_ref)
        if held is not None and component_ref not in self._clearing:
            # It may have resumed meanwhile.
            self.telling.adapter(component_ref, session_of(held[0]), held[1], holds=True)
            self.telling.to_all(component_ref, None, SENTENCES[why])

    def _advance(self) -> None:
        self._carry(self.model.advance(self._now()))
