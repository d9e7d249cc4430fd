"""Leases at work: the operations of sessions, by the rules and a clock."""

import asyncio
import time
from collections.abc import Awaitable, Callable, Iterable

from openrois.aio.tasks import TaskScope
from openrois.auth.principal import Principal
from openrois.auth.ranks import Ranks
from openrois.commands.pending import PendingCommands
from openrois.commands.stop_latch import StopLatch
from openrois.engine.engine import Engine
from openrois.leases.alarm import Alarm
from openrois.leases.body_parts import BodyParts
from openrois.leases.carrying import LeaseCarrier
from openrois.leases.changes import Change, Gained, Why
from openrois.leases.epochs import Epochs
from openrois.leases.lease_notifications import Holder, LeaseNotifications, session_of
from openrois.leases.model import LeaseModel, Replayed, Rules
from openrois.types.references import engine_of

__all__ = ["LeaseKeeper"]


class LeaseKeeper:
    """Keeps the leases of one engine.

    Args:
        engine: whose components are held.
        tasks: owns what goes on when a call has been answered.
        pending: the commands that end when their component is handed over.
        rules: how long what lasts.
        epochs: gives the numbers of epochs; without it they are counted from 1.
        latch: which engines persons have stopped for programs; without it none.
        ranks: tell which holders are programs.
        clock: monotonic seconds.
        sleep: waits for some seconds.
        acted: records components that change hands without their new or former holder asking for it at that moment:
            whose, what, which component, and why.
        on_lost: called when a session does not hold a component any more.

    Attributes:
        model: the rules, and how things stand.
        notifications: sends them.
        carrier: carries out what changes.
    """

    def __init__(
        self,
        engine: Engine,
        tasks: TaskScope,
        pending: PendingCommands,
        *,
        rules: Rules | None = None,
        epochs: Epochs | None = None,
        latch: StopLatch | None = None,
        ranks: Ranks | None = None,
        clock: Callable[[], float] = time.monotonic,
        sleep: Callable[[float], Awaitable[None]] = asyncio.sleep,
        acted: Callable[[Principal, str, str, str], None] = lambda _who, _method, _component_ref, _detail: None,
        on_lost: Callable[[str, Holder], None] = lambda _component_ref, _holder: None,
    ) -> None:
        latch, ranks = StopLatch() if latch is None else latch, ranks or Ranks()
        self.model = LeaseModel(rules, epochs, parts=BodyParts(engine), may_return=_returning(latch, ranks))
        self._engine = engine
        self.notifications = LeaseNotifications(self.model, engine, tasks, clock, latch, ranks)
        self.carrier = LeaseCarrier(self.model, engine, tasks, pending, self.notifications, acted, on_lost)
        self._alarm = Alarm(self._advance, tasks, clock, sleep)
        self._now = clock

    def is_held(self, component_ref: str, holder: Holder) -> bool:
        """Tell whether `holder` holds the component, and nothing of a former holder runs there any more."""
        return self.model.holding.is_held(component_ref, holder) and not self.carrier.is_clearing(component_ref)

    def is_held_by_another(self, component_ref: str, holder: Holder) -> bool:
        """Tell whether the component has a holder other than `holder`."""
        return self.model.holding.is_held_by_another(component_ref, holder)

    def why_not(self, component_ref: str, holder: Holder) -> str:
        """Return why `holder` may not operate a component, as a sentence that says what to do."""
        if self.model.loans.find(self.model.holding.part_of(component_ref), holder) is None:
            return f"{component_ref} has to be bound first"
        lease = self.notifications.status(component_ref, holder)
        seconds = lease.return_ms / 1000
        return (
            f"{component_ref} was taken for a time by {lease.holder}, and comes back in {seconds:.0f} s at the latest"
        )

    def bind(self, component_ref: str, holder: Holder) -> int:
        """Reserve a component and return the epoch; its adapter is notified, also when `holder` has it already.

        Raises:
            OutOfResources: another session holds it.
        """
        is_new = self.model.holding.holder(component_ref) is None
        epoch = self.model.holding.bind(component_ref, holder)
        if is_new:
            self._carry([Gained(component_ref, holder, epoch, Why.BOUND)], (holder, component_ref))
        else:
            self.notifications.adapter(component_ref, holder, epoch, holds=True)
        return epoch

    def release(self, component_ref: str, holder: Holder) -> None:
        """Release a component, if `holder` has it: its last lender, or else the first in the queue, has it next."""
        self._carry(self.model.release(component_ref, holder, self._now()), (holder, component_ref))

    def hand_back(self, component_ref: str, holder: Holder) -> None:
        """Release all of the part of a component, if `holder` has it."""
        self._carry(self.model.hand_back(component_ref, holder, self._now()), (holder, component_ref))

    def note_ended(self, component_ref: str, holder: Holder) -> None:
        """Note that what a holder has started has ended: a part that was taken for no more goes back."""
        self._carry(self.model.note_ended(component_ref, holder, self._now()))

    def leave(self, holder: Holder) -> None:
        """Release everything, and withdraw every request. The adapters learn that from `forget_client`."""
        self.notifications.forget_watcher(holder)
        self._carry(self.model.leave(holder, self._now()))

    def lose(self, holder: Holder) -> None:
        """Note that a connection was lost: what a session with a resume token holds is kept for the grace."""
        self.notifications.forget_watcher(holder)
        self._carry(self.model.lose(holder, self._now()))

    def end_all(self, component_refs: Iterable[str]) -> None:
        """End the leases of components that are no longer there."""
        self._carry(self.model.end_all(component_refs, self._now()))

    def end_moved(self, engine_ids: Iterable[str]) -> None:
        """End the leases of components that belong to another part now than when they were bound."""
        refs = [ref for engine_id in engine_ids for ref in self._engine.acting_of(engine_id)]
        self.end_all(self.model.holding.moved(refs))

    def request(self, component_ref: str, asker: Holder) -> str:
        """Request a component; return the id of the request, or empty text where no holder has to be asked.

        Raises:
            OutOfResources: too many wait for it.
        """
        self._carry(self.model.request(component_ref, asker, self._now()), (asker, component_ref))
        request = self.model.waiting.find(self.model.holding.part_of(component_ref), asker)
        return "" if request is None else request.request_id

    def withdraw(self, component_ref: str, asker: Holder) -> None:
        """Withdraw the request for a component."""
        self._carry(self.model.withdraw(component_ref, asker), (asker, component_ref))

    def grant(self, request_id: str, holder: Holder) -> str:
        """Hand the component over once what runs there has been stopped; return which it is.

        Raises:
            Unsupported: `holder` was not asked that.
        """
        changes = self.model.grant(request_id, holder, self._now())
        self._carry(changes)
        return next((change.component_ref for change in changes if isinstance(change, Gained)), "")

    async def borrow(self, component_ref: str, borrower: Holder, seconds: float | None, *, for_one: bool) -> None:
        """Take a component with its part for a time from a holder of lower rank, once what runs there was stopped."""
        self._carry(self.model.borrow(component_ref, borrower, self._now(), seconds, for_one=for_one))
        await self.carrier.cleared(component_ref)

    def decline(self, request_id: str, holder: Holder) -> None:
        """Keep the component.

        Raises:
            Unsupported: `holder` was not asked that.
        """
        self._carry(self.model.decline(request_id, holder))

    async def take(self, component_ref: str, taker: Holder) -> None:
        """Take a component from its holder, once what runs there has been stopped."""
        self._carry(self.model.take(component_ref, taker, self._now()))
        await self.carrier.cleared(component_ref)

    def token(self, holder: Holder) -> str:
        """Return the token that resumes the session when its connection is lost.

        Raises:
            Unsupported: leases do not survive a connection here.
        """
        return self.model.token(holder, holder.principal.subject)

    def resume(self, token: str, successor: Holder) -> object:
        """Let a session go on in the place of another; return that one. Adapters are notified of the holders.

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
        self._go_on(successor, changes)
        return former

    def succeed(self, former: Holder, successor: Holder) -> None:
        """Let a session go on in the place of another, whose token was shown elsewhere."""
        self._go_on(successor, self.model.succeed(former, successor, self._now()))

    def reserve(self, component_ref: str, holder: Holder) -> None:
        """Keep a free component for a session that has held it at another gateway, for the grace.

        Raises:
            OutOfResources: there is no epoch for it.
        """
        self._carry(self.model.reserve(component_ref, holder, holder.principal.subject, self._now()))

    def _go_on(self, successor: Holder, changes: list[Change]) -> None:
        begun = {change.component_ref for change in changes if isinstance(change, Gained)}
        for component_ref, epoch in self.model.holding.held_by(successor).items():
            successor.bound.add(component_ref)
            if component_ref not in begun:
                self.notifications.adapter(component_ref, successor, epoch, holds=True)
        self._carry(changes, (successor, ""))

    # How it is done.

    def _carry(self, changes: list[Change], answered: tuple[Holder, str] | None = None) -> None:
        self.carrier.carry(changes, answered)
        self._alarm.set(self.model.next_due())

    def _advance(self) -> None:
        self._carry(self.model.advance(self._now()))


def _returning(latch: StopLatch, ranks: Ranks) -> Callable[[object, str], bool]:
    """Return what tells whether a part that was lent may come back: a person's STOP keeps it from programs."""

    def may_return(lender: object, part: str) -> bool:
        return not latch.by(engine_of(part)) or not ranks.is_program(session_of(lender).principal)

    return may_return
