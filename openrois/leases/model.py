"""The rules of leases: bind, release, queue, hand-over, loans, grace after a lost connection. Time is an argument.

Pure.
"""

import secrets
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Final

from openrois.errors import Unsupported
from openrois.leases.changes import Asked, Change, Declined, Gained, Lost, Queued, Why
from openrois.leases.epochs import Epochs
from openrois.leases.holding import Holding
from openrois.leases.loans import Loan, Loans
from openrois.leases.moves import Moves, not_returned
from openrois.leases.parts import LoneComponents, Parts
from openrois.leases.tokens import ResumeTokens, new_token
from openrois.leases.waiting import Request, Waiting

__all__ = ["GRACE", "LOAN", "PATIENCE", "LeaseModel", "Replayed", "Rules"]

GRACE: Final = 10.0
"""Seconds for which a lease survives the connection of its holder."""

PATIENCE: Final = 30.0
"""Seconds that a holder has to answer a request for its component."""

LOAN: Final = 30.0
"""Seconds for which a part is taken from a holder of lower rank, unless it is taken again meanwhile."""

_NOT_VALID: Final = "the resume token is not valid"


class Replayed(Unsupported):
    """A resume token came a second time: one of its two users is a thief.

    Attributes:
        holder: the session that has gone on by it, and is not resumed again.
        changes: what follows.
    """

    def __init__(self, holder: object, changes: list[Change]) -> None:
        super().__init__(_NOT_VALID)
        self.holder = holder
        self.changes = changes


@dataclass(frozen=True, slots=True)
class Rules:
    """Settings of leases by the operator of a gateway.

    Attributes:
        grace: seconds for which a lease survives a lost connection; 0 for none.
        patience: seconds that a holder has to answer a request.
        loan: seconds for which a part is taken from a holder of lower rank.
    """

    grace: float = GRACE
    patience: float = PATIENCE
    loan: float = LOAN


class LeaseModel:
    """The leases of one engine. A part has one holder or none; a free part has neither queue nor lenders.

    Holders are any objects; identity decides. What follows from an operation is returned as changes, to be notified in
    their order. A component that belongs to no part is one by itself.

    Args:
        rules: how long what lasts.
        epochs: gives the numbers of epochs; without it they are counted from 1.
        mint: makes tokens.
        parts: which components belong together.
        may_return: tells whether what was taken for a time may come back to a session now.

    Attributes:
        holding: the holder of each component. A free part has no queue, so to bind a component needs nothing but this.
        waiting: the queue of each part.
        loans: the lenders of each part.
        absent: whose connection was lost, and until when it may be resumed.
    """

    def __init__(
        self,
        rules: Rules | None = None,
        epochs: Epochs | None = None,
        mint: Callable[[], str] = new_token,
        parts: Parts | None = None,
        may_return: Callable[[object, str], bool] = lambda _lender, _part: True,
    ) -> None:
        self.rules = rules or Rules()
        self._parts = parts or LoneComponents()
        self.holding = Holding(epochs, self._parts.part_of)
        self.waiting = Waiting()
        self.loans = Loans()
        self._tokens = ResumeTokens(mint)
        self.absent: dict[object, float] = {}
        self._moves = Moves(self.holding, self.waiting, self.loans, self._parts, self.rules.patience, may_return)

    def has_any(self, holder: object) -> bool:
        """Tell whether a session holds anything, or has lent it."""
        return bool(self.holding.held_by(holder)) or next(self.loans.of_lender(holder), None) is not None

    def owned_by(self, holder: object) -> dict[str, int]:
        """Return the epochs of what a session has in its own right: what it holds and has not borrowed, or has lent."""
        held = {
            ref: epoch
            for ref, epoch in self.holding.held_by(holder).items()
            if self.loans.of(self.holding.part_of(ref)) is None
        }
        lent = (lender.epochs for _, lender in self.loans.of_lender(holder) if lender.loan is None)
        return dict(item for epochs in (held, *lent) for item in epochs.items())

    def lent_by(self, holder: object) -> list[str]:
        """Return the components that were taken from a session for a time."""
        return [ref for _, place in self.loans.of_lender(holder) for ref in place.epochs]

    def waited_for(self, asker: object) -> list[str]:
        """Return the components that a session waits for."""
        return [request.component_ref for request in self.waiting.of(asker)]

    def next_due(self) -> float | None:
        """Return when `advance` has something to do; None for never."""
        answers = [request.deadline for request in self.waiting.unanswered() if request.deadline is not None]
        return min((*self.absent.values(), *answers, *self.loans.deadlines()), default=None)

    def release(self, component_ref: str, holder: object, now: float, why: Why = Why.RELEASED) -> list[Change]:
        """Release a component. Nothing changes if `holder` neither holds nor has lent it.

        With the last of its part that the holder has named, all of the part goes on: to its last lender, or else to the
        first in the queue. A lender gives up its place.
        """
        part = self.holding.part_of(component_ref)
        epoch = self.holding.release(component_ref, holder)
        if epoch is None:
            return self._moves.give_up(part, holder, (component_ref,), why)
        changes: list[Change] = [Lost(component_ref, holder, epoch, why, self.loans.of(part) is not None)]
        return changes if self.holding.named_of(part) else [*changes, *self._moves.free(part, now, why)]

    def hand_back(self, component_ref: str, holder: object, now: float) -> list[Change]:
        """Release all of the part of a component. Nothing changes if `holder` does not hold it."""
        part = self.holding.part_of(component_ref)
        return [] if self.holding.holder_of(part) is not holder else self._moves.free(part, now, Why.RELEASED)

    def leave(self, holder: object, now: float, why: Why = Why.LEFT) -> list[Change]:
        """Release everything, give up what was lent, withdraw every request, and forget the resume tokens."""
        self.absent.pop(holder, None)
        self._tokens.forget_holder(holder)
        for part, lender in self.loans.of_lender(holder):
            self.loans.remove(part, lender)
        changes = self._moves.withdraw_all(holder)
        for part in self.holding.parts_of(holder):
            changes += self._moves.free(part, now, why)
        return changes

    def end_all(self, component_refs: Iterable[str], now: float = 0.0) -> list[Change]:
        """End the leases of components that are no longer there, and the waiting for them."""
        changes: list[Change] = []
        gone = frozenset(component_refs)
        for part, lender in self.loans.all():
            if not gone.isdisjoint(lender.epochs):
                changes += self._moves.give_up(part, lender.holder, gone, Why.GONE)
        freed: dict[str, None] = {}
        for component_ref in sorted(ref for ref in gone if self.holding.holder(ref) is not None):
            part = self.holding.part_of(component_ref)
            holder, epoch = self._moves.held(component_ref)
            self.holding.release(component_ref, holder)
            changes.append(Lost(component_ref, holder, epoch, Why.GONE, self.loans.of(part) is not None))
            freed[part] = None
        for part in freed:
            if not self.holding.named_of(part):
                changes += self._moves.end_part(part, gone, now)
        return changes

    # Hand-over.

    def request(self, component_ref: str, asker: object, now: float) -> list[Change]:
        """Request a component with its part: hold it where it is free, or else wait while the holder is asked.

        A session that waits already keeps its place; the holder is asked again if it has answered, or did not in time.

        Raises:
            OutOfResources: too many wait for it, or there is no epoch left.
        """
        part = self.holding.part_of(component_ref)
        holder = self.holding.holder_of(part)
        if holder is None or holder is asker:
            return self._moves.gain(part, asker, Why.BOUND, component_ref)
        request = self.waiting.find(part, asker)
        if request is None:
            request = Request(secrets.token_hex(16), part, component_ref, asker, None)
            self.waiting.add(request)
        if request.deadline is not None:
            return []
        request.deadline = now + self.rules.patience
        return [Asked(request, holder), *self._moves.queued(part)]

    def withdraw(self, component_ref: str, asker: object) -> list[Change]:
        """Withdraw the request for a component."""
        request = self.waiting.find(self.holding.part_of(component_ref), asker)
        return [] if request is None else self._moves.withdraw(request)

    def grant(self, request_id: str, holder: object, now: float) -> list[Change]:
        """Hand the part over to the session that asked, on the terms on which the holder has it.

        Raises:
            Unsupported: `holder` was not asked that.
            OutOfResources: there is no epoch left.
        """
        request = self._asked(request_id, holder)
        return self._moves.hand_over(request.part, request.asker, now, Why.GRANTED, request.component_ref)

    def decline(self, request_id: str, holder: object) -> list[Change]:
        """Keep the part; the session that asked may go on waiting for it.

        Raises:
            Unsupported: `holder` was not asked that.
        """
        request = self._asked(request_id, holder)
        request.deadline = None
        return [Declined(request, in_time=True)]

    def take(self, component_ref: str, taker: object, now: float) -> list[Change]:
        """Take a component with its part, for good. Whether the caller may do that is not checked here.

        Raises:
            OutOfResources: there is no epoch left.
        """
        part = self.holding.part_of(component_ref)
        if self.holding.holder_of(part) in (None, taker):
            return self.request(component_ref, taker, now)
        changes = self._moves.hand_over(part, taker, now, Why.TAKEN, component_ref)
        ended = [change for lender in self.loans.end_all_of(part) for change in not_returned(lender, Why.TAKEN)]
        return [*changes, *ended]

    # Loans.

    def borrow(
        self, component_ref: str, borrower: object, now: float, seconds: float | None = None, *, for_one: bool = False
    ) -> list[Change]:
        """Take a component with its part for a time: then, or when it is given back, its holder has it again.

        A borrower that asks again has it so long from now on. A part that is free is simply held. Whether the caller
        may do that is not checked here.

        Args:
            component_ref: the component.
            borrower: has its part from now on.
            now: monotonic seconds.
            seconds: for which it is taken; those of the rules unless given.
            for_one: whether it goes back as soon as what the borrower has begun there has ended.

        Raises:
            OutOfResources: there is no epoch left.
        """
        part = self.holding.part_of(component_ref)
        holder = self.holding.holder_of(part)
        loan = Loan(now + (self.rules.loan if seconds is None else seconds), for_one)
        if holder is None:
            return self.request(component_ref, borrower, now)
        if holder is not borrower:
            return self._moves.lend(part, borrower, now, loan, component_ref)
        changes = self.request(component_ref, borrower, now)
        if self.loans.of(part) is None:
            return changes
        self.loans.extend(part, loan)
        return [*changes, *self._moves.queued(part)]

    def note_ended(self, component_ref: str, holder: object, now: float) -> list[Change]:
        """Note that all has ended that a holder had begun on a part: one that was taken for no more goes back."""
        part = self.holding.part_of(component_ref)
        loan = self.loans.of(part)
        if loan is None or not loan.for_one or self.holding.holder_of(part) is not holder:
            return []
        return self._moves.free(part, now, Why.DUE)

    # A lost connection.

    def token(self, holder: object, subject: str) -> str:
        """Return the token with which another session resumes this one: valid once, for that subject.

        Raises:
            Unsupported: leases do not survive a connection here.
        """
        if self.rules.grace <= 0:
            raise Unsupported("this gateway ends leases with their connection (--lease-grace 0)")
        return self._tokens.issue(holder, subject)

    def lose(self, holder: object, now: float) -> list[Change]:
        """Note that a connection was lost: what a session with a token holds is kept for the grace, but no loan is."""
        if not self._tokens.has_one(holder):
            return self.leave(holder, now)
        self.absent[holder] = now + self.rules.grace
        changes = self._moves.withdraw_all(holder)
        for part in self.holding.parts_of(holder):
            changes += self._moves.queued(part) if self.loans.of(part) is None else self._moves.free(part, now, Why.DUE)
        return changes

    def resume(self, token: str, subject: str, successor: object, now: float) -> tuple[object, list[Change]]:
        """Let a new session hold what another one held; return which that was.

        Of one whose connection was lost the epochs go on. One that still has its connection, as far as is known, is
        put out: new epochs begin, so that whatever comes of it yet is late.

        Raises:
            Unsupported: the token is unknown, another subject's or the successor's own, or its time is over.
            Replayed: it comes a second time; what was resumed by it is not resumed again.
            OutOfResources: there is no epoch left, and the token is still valid.
        """
        found = self._tokens.find(token, subject)
        former = found.holder
        if former is None:
            raise Unsupported(_NOT_VALID)
        if found.replayed:
            raise Replayed(former, self.leave(former, now, Why.EXPIRED) if former in self.absent else [])
        if former is successor:
            raise Unsupported("this token is the session's own: resume a former one")
        return former, self.succeed(former, successor, now)

    def may_go_on(self, holder: object) -> bool:
        """Tell whether another session may go on in the place of this one: it has had a token, and has not left."""
        return self._tokens.knows(holder)

    def succeed(self, former: object, successor: object, now: float) -> list[Change]:
        """Let a session hold what another one held, as `resume` does; that it may was found out elsewhere.

        Args:
            former: the session, which may go on.
            successor: goes on in its place.
            now: monotonic seconds.

        Raises:
            OutOfResources: there is no epoch left.
        """
        was_lost, held = former in self.absent, self.holding.held_by(former)
        parts = self.holding.parts_of(former)
        refs = () if was_lost else [ref for part in parts for ref in self.holding.held_of(part)]
        begun = {ref: self.holding.next_epoch(ref) for ref in refs}
        self._tokens.succeed(former, successor)
        self.absent.pop(former, None)
        changes = self._moves.withdraw_all(former)
        for part, lender in self.loans.of_lender(former):
            lender.holder = successor
            changes += self._moves.queued(part)
        for part in parts:
            request = self.waiting.find(part, successor)
            if request is not None:
                self.waiting.remove(request)
            on_loan = self.loans.of(part) is not None
            for component_ref in self.holding.held_of(part):
                if was_lost:
                    self.holding.succeed(component_ref, successor)
                else:
                    is_implied = self.holding.is_implied(component_ref)
                    gained = self.holding.move(component_ref, successor, begun[component_ref], is_implied=is_implied)
                    changes.append(Lost(component_ref, former, held[component_ref], Why.RESUMED, on_loan))
                    changes.append(Gained(component_ref, successor, gained, Why.RESUMED, on_loan))
            changes += self._moves.queued(part)
            queue = self.waiting.queue(part)
            changes += [Asked(request, successor) for request in queue if request.deadline is not None]
        return changes

    def reserve(self, component_ref: str, holder: object, subject: str, now: float) -> list[Change]:
        """Keep a free component for a session that has held it at another engine, as if its connection had been lost.

        Nothing changes where another session holds the component already.

        Args:
            component_ref: the component.
            holder: stands for the session until that comes, or the grace is over.
            subject: of the session.
            now: monotonic seconds.

        Raises:
            OutOfResources: there is no epoch for it.
        """
        other = self.holding.holder_of(self.holding.part_of(component_ref))
        if self.rules.grace <= 0 or other not in (None, holder) or self.holding.holder(component_ref) is not None:
            return []
        self.holding.move(component_ref, holder)
        if not self._tokens.has_one(holder):
            self._tokens.issue(holder, subject)
        self.absent[holder] = now + self.rules.grace
        return [Queued(component_ref)]

    def advance(self, now: float) -> list[Change]:
        """Do what is due: graces and loans that are over, and answers that did not come."""
        changes: list[Change] = []
        for holder in [holder for holder, until in self.absent.items() if until <= now]:
            changes += self.leave(holder, now, Why.EXPIRED)
        changes += self._moves.end_loans(now)
        for request in self.waiting.unanswered():
            if request.deadline is not None and request.deadline <= now:
                request.deadline = None
                changes.append(Declined(request, in_time=False))
        return changes

    # How it is done.

    def _asked(self, request_id: str, holder: object) -> Request:
        request = self.waiting.get(request_id)
        if request is None or self.holding.holder_of(request.part) is not holder:
            raise Unsupported(f"there is no request {request_id[:200]!r}")
        return request
