"""How a part changes hands: all of its components in one step, each in a new epoch, or none. Pure."""

from collections.abc import Callable, Collection, Iterable

from openrois.errors import OutOfResources
from openrois.leases.changes import Asked, Change, Declined, Gained, Lost, NotReturned, Queued, Why, Withdrawn
from openrois.leases.holding import Holding
from openrois.leases.loans import Lender, Loan, Loans
from openrois.leases.parts import Parts
from openrois.leases.waiting import Request, Waiting

__all__ = ["Moves", "not_returned"]


class Moves:
    """Moves the parts of one engine between sessions. What follows from a move is returned as changes.

    Args:
        holding: the holders.
        waiting: the queues.
        loans: the lenders.
        parts: which components belong together.
        patience: seconds that a holder has to answer a request.
        may_return: tells whether what was lent may come back to a session now.
    """

    def __init__(
        self,
        holding: Holding,
        waiting: Waiting,
        loans: Loans,
        parts: Parts,
        patience: float,
        may_return: Callable[[object, str], bool],
    ) -> None:
        self._holding = holding
        self._waiting = waiting
        self._loans = loans
        self._parts = parts
        self._patience = patience
        self._may_return = may_return

    # A part that is free.

    def gain(self, part: str, holder: object, why: Why, named: str) -> list[Change]:
        """Let a session hold all of a part that it does not hold yet.

        Args:
            part: the part; no other session holds any of it.
            holder: the session.
            why: the reason.
            named: the component of it that the session has named.

        Raises:
            OutOfResources: there is no epoch left, and nothing has changed.
        """
        if self._holding.is_held(named, holder):
            self._holding.bind(named, holder)
        wanted = self._members(part, holder, named)
        missing = (ref for ref in wanted if not self._holding.is_held(ref, holder))
        return self._gain_each(self._with_epochs(missing), holder, why, (named,))

    def _members(self, part: str, holder: object, named: str) -> Iterable[str]:
        return dict.fromkeys((named, *self._parts.members(part, holder)))

    def _with_epochs(self, component_refs: Iterable[str]) -> list[tuple[str, int]]:
        """Return components with an epoch that may begin: where there is none for one of them, none has moved."""
        return [(ref, self._holding.next_epoch(ref)) for ref in component_refs]

    def _gain_each(
        self, begun: Iterable[tuple[str, int]], holder: object, why: Why, named: Collection[str]
    ) -> list[Change]:
        for ref, epoch in begun:
            self._holding.move(ref, holder, epoch, is_implied=ref not in named)
        return [Gained(ref, holder, epoch, why, self._is_on_loan(ref)) for ref, epoch in begun]

    def _is_on_loan(self, component_ref: str) -> bool:
        return self._loans.of(self._holding.part_of(component_ref)) is not None

    def free(self, part: str, now: float, why: Why) -> list[Change]:
        """Take all of a part from its holder, and pass it on."""
        return [*self._lose_each(part, why), *self.pass_on(part, now, why)]

    def _lose_each(self, part: str, why: Why) -> list[Change]:
        changes: list[Change] = []
        for ref in self._holding.held_of(part):
            holder, epoch = self.held(ref)
            self._holding.release(ref, holder)
            changes.append(Lost(ref, holder, epoch, why, self._loans.of(part) is not None))
        return changes

    def pass_on(self, part: str, now: float, why: Why) -> list[Change]:
        """Let the next session have a part that is free now: its last lender, or else the first in the queue."""
        changes: list[Change] = []
        while (lender := self._loans.take_back(part)) is not None:
            returned = self._give_back(part, lender)
            changes += returned
            if any(isinstance(change, Gained) for change in returned):
                return [*changes, *self.ask_again(part, now)]
        queue = self._waiting.queue(part)
        if not queue:
            return changes
        first = queue[0]
        try:
            changes += self.gain(part, first.asker, why, first.component_ref)
        except OutOfResources as error:
            return [*changes, *self.decline_all(queue, str(error))]
        self._waiting.remove(first)
        return [*changes, *self.ask_again(part, now)]

    def _give_back(self, part: str, lender: Lender) -> list[Change]:
        if not self._may_return(lender.holder, part):
            return not_returned(lender, Why.LATCHED)
        try:
            begun = self._with_epochs(lender.epochs)
        except OutOfResources:
            return not_returned(lender, Why.DUE)
        return self._gain_each(begun, lender.holder, Why.RETURNED, lender.named)

    # A part that is held.

    def hand_over(self, part: str, successor: object, now: float, why: Why, named: str) -> list[Change]:
        """Take a part from its holder, and let a successor have all of it on the same terms.

        One that has lent it has it back, on its own terms; the places of those that have it from there end.

        Raises:
            OutOfResources: there is no epoch left, and nothing has changed.
        """
        begun = self._with_epochs(self._members(part, successor, named))
        changes: list[Change] = self._lose_each(part, why)
        while self._loans.find(part, successor) is not None:
            lender = self._loans.take_back(part)
            if lender is not None and lender.holder is not successor:
                changes += not_returned(lender, why)
        changes += self._gain_each(begun, successor, why, (named,))
        self._forget_request(part, successor)
        return [*changes, *self.ask_again(part, now)]

    def lend(self, part: str, borrower: object, now: float, loan: Loan, named: str) -> list[Change]:
        """Take a part from its holder for a time; the holder becomes its last lender.

        Raises:
            OutOfResources: there is no epoch left, and nothing has changed.
        """
        begun = self._with_epochs(self._members(part, borrower, named))
        own = self._loans.find(part, borrower)
        if own is not None:
            self._loans.remove(part, own)
        epochs = {ref: self.held(ref)[1] for ref in self._holding.held_of(part)}
        lender = Lender(self._holding.holder_of(part), epochs, self._holding.named_of(part), self._loans.of(part))
        changes = self._lose_each(part, Why.LENT)
        self._loans.lend(part, lender, loan)
        changes += self._gain_each(begun, borrower, Why.LENT, (named,))
        self._forget_request(part, borrower)
        return [*changes, *self.ask_again(part, now)]

    def held(self, component_ref: str) -> tuple[object, int]:
        """Return the holder and the epoch of a component that is held."""
        held = self._holding.holder(component_ref)
        assert held is not None, "a free part has neither queue nor lenders"
        return held

    def give_up(self, part: str, lender: object, component_refs: Iterable[str], why: Why) -> list[Change]:
        """Let a lender not have back some of what was taken from it."""
        place = self._loans.find(part, lender)
        if place is None:
            return []
        before = dict(place.epochs)
        self._loans.give_up(place, tuple(component_refs))
        if not place.epochs:
            self._loans.remove(part, place)
        ended = [NotReturned(ref, lender, epoch, why) for ref, epoch in before.items() if ref not in place.epochs]
        return [*ended, *self.queued(part)] if ended else []

    def end_part(self, part: str, gone: Collection[str], now: float) -> list[Change]:
        """Pass on what is left of a part of which the holder has lost all; where nothing is, the waiting ends."""
        queue = self._waiting.queue(part)
        is_left = any(ref not in gone for request in queue for ref in self._parts.members(part, request.asker))
        if self._holding.held_of(part) or self._loans.lenders(part) or is_left:
            return self.free(part, now, Why.GONE)
        self._loans.take_back(part)
        return self.decline_all(queue)

    def end_loans(self, now: float) -> list[Change]:
        """End the loans that are over."""
        changes: list[Change] = []
        while True:
            lenders, parts = self._loans.due(now)
            if not lenders and not parts:
                return changes
            for part, lender in lenders:
                self._loans.remove(part, lender)
                changes += [*not_returned(lender, Why.DUE), *self.queued(part)]
            for part in parts:
                changes += self.free(part, now, Why.DUE)

    # The queue.

    def ask_again(self, part: str, now: float) -> list[Change]:
        """Ask a new holder what the former one was asked."""
        queue = self._waiting.queue(part)
        holder = self._holding.holder_of(part)
        for request in queue:
            request.deadline = now + self._patience
        return [*(Asked(request, holder) for request in queue), *self.queued(part)]

    def queued(self, part: str) -> list[Change]:
        """Return that the queue of a part may be another now."""
        asked = (request.component_ref for request in self._waiting.queue(part))
        return [Queued(ref) for ref in dict.fromkeys((*self._holding.held_of(part), *asked))]

    def decline_all(self, queue: Iterable[Request], problem: str = "") -> list[Change]:
        """End the waiting for a part: it is gone, unless there is another problem."""
        changes: list[Change] = []
        for request in queue:
            self._waiting.remove(request)
            changes.append(Declined(request, in_time=True, gone=not problem, problem=problem))
        return changes

    def withdraw(self, request: Request) -> list[Change]:
        """Withdraw a request."""
        holder = self._holding.holder_of(request.part)
        assert holder is not None, "a free part has no queue"
        self._waiting.remove(request)
        queued = dict.fromkeys((*self.queued(request.part), Queued(request.component_ref)))
        return [Withdrawn(request, holder), *queued]

    def withdraw_all(self, asker: object) -> list[Change]:
        """Withdraw every request of a session."""
        return [change for request in self._waiting.of(asker) for change in self.withdraw(request)]

    def _forget_request(self, part: str, asker: object) -> None:
        request = self._waiting.find(part, asker)
        if request is not None:
            self._waiting.remove(request)


def not_returned(lender: Lender, why: Why) -> list[Change]:
    """Return that nothing of what was taken from a lender comes back to it."""
    return [NotReturned(ref, lender.holder, epoch, why) for ref, epoch in lender.epochs.items()]
