"""The rules of leases: bind, release, grace after a lost connection, resume, queue, hand-over. Time is an argument.

Pure.
"""

import secrets
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Final

from openrois.errors import OutOfResources, Unsupported
from openrois.leases.changes import Asked, Change, Declined, Gained, Lost, Queued, Why, Withdrawn
from openrois.leases.epochs import Epochs
from openrois.leases.holding import Holding
from openrois.leases.tokens import ResumeTokens, new_token
from openrois.leases.waiting import Request, Waiting

__all__ = ["GRACE", "PATIENCE", "LeaseModel", "Replayed", "Rules"]

GRACE: Final = 10.0
"""Seconds for which a lease survives the connection of its holder."""

PATIENCE: Final = 30.0
"""Seconds that a holder has to answer a request for its component."""

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
    """

    grace: float = GRACE
    patience: float = PATIENCE


class LeaseModel:
    """The leases of one engine. A component has one holder or none; a free component has no queue.

    Holders are any objects; identity decides. What follows from an operation is returned as changes, to be notified in
    their order.

    Args:
        rules: how long what lasts.
        epochs: gives the numbers of epochs; without it they are counted from 1.
        mint: makes tokens.

    Attributes:
        holding: the holder of each component. A free component has no queue, so to bind one needs nothing but this.
        waiting: the queue of each component.
        absent: whose connection was lost, and until when it may be resumed.
    """

    def __init__(
        self, rules: Rules | None = None, epochs: Epochs | None = None, mint: Callable[[], str] = new_token
    ) -> None:
        self.rules = rules or Rules()
        self.holding = Holding(epochs)
        self.waiting = Waiting()
        self._tokens = ResumeTokens(mint)
        self.absent: dict[object, float] = {}

    def next_due(self) -> float | None:
        """Return when `advance` has something to do; None for never."""
        deadlines = [request.deadline for request in self.waiting.unanswered() if request.deadline is not None]
        return min((*self.absent.values(), *deadlines), default=None)

    def release(self, component_ref: str, holder: object, now: float, why: Why = Why.RELEASED) -> list[Change]:
        """Release a component; the first in the queue has it next. Nothing changes if `holder` does not hold it."""
        epoch = self.holding.release(component_ref, holder)
        if epoch is None:
            return []
        changes: list[Change] = [Lost(component_ref, holder, epoch, why)]
        queue = self.waiting.queue(component_ref)
        if not queue:
            return changes
        try:
            gained = self.holding.move(component_ref, queue[0].asker)
        except OutOfResources as error:
            return [*changes, *self._decline_all(queue, str(error))]
        self.waiting.remove(queue[0])
        return [*changes, Gained(component_ref, queue[0].asker, gained, why), *self._ask_again(component_ref, now)]

    def leave(self, holder: object, now: float, why: Why = Why.LEFT) -> list[Change]:
        """Release everything, withdraw every request, and forget the resume tokens."""
        self.absent.pop(holder, None)
        self._tokens.forget_holder(holder)
        changes = self._withdraw_all(holder)
        for component_ref in self.holding.held_by(holder):
            changes += self.release(component_ref, holder, now, why)
        return changes

    def end_all(self, component_refs: Iterable[str]) -> list[Change]:
        """End the leases of components that are no longer there, and the waiting for them."""
        changes: list[Change] = []
        for component_ref in sorted(ref for ref in component_refs if self.holding.holder(ref) is not None):
            held = self._held(component_ref)
            self.holding.release(component_ref, held[0])
            changes.append(Lost(component_ref, held[0], held[1], Why.GONE))
            changes += self._decline_all(self.waiting.queue(component_ref))
        return changes

    # Hand-over.

    def request(self, component_ref: str, asker: object, now: float) -> list[Change]:
        """Request a component: hold it where it is free, or else wait in the queue while the holder is asked.

        A session that waits already keeps its place; the holder is asked again if it has answered, or did not in time.

        Raises:
            OutOfResources: too many wait for it, or there is no epoch left.
        """
        held = self.holding.holder(component_ref)
        if held is None:
            return [Gained(component_ref, asker, self.holding.move(component_ref, asker), Why.BOUND)]
        if held[0] is asker:
            return []
        request = self.waiting.find(component_ref, asker)
        if request is None:
            request = Request(secrets.token_hex(16), component_ref, asker, None)
            self.waiting.add(request)
        if request.deadline is not None:
            return []
        request.deadline = now + self.rules.patience
        return [Asked(request, held[0]), Queued(component_ref)]

    def withdraw(self, component_ref: str, asker: object) -> list[Change]:
        """Withdraw the request for a component."""
        request = self.waiting.find(component_ref, asker)
        return [] if request is None else self._withdraw(request)

    def grant(self, request_id: str, holder: object, now: float) -> list[Change]:
        """Hand the component over to the session that asked.

        Raises:
            Unsupported: `holder` was not asked that.
            OutOfResources: there is no epoch left.
        """
        request = self._asked(request_id, holder)
        return self._hand_over(request.component_ref, request.asker, now, Why.GRANTED)

    def decline(self, request_id: str, holder: object) -> list[Change]:
        """Keep the component; the session that asked may go on waiting for it.

        Raises:
            Unsupported: `holder` was not asked that.
        """
        request = self._asked(request_id, holder)
        request.deadline = None
        return [Declined(request, in_time=True)]

    def take(self, component_ref: str, taker: object, now: float) -> list[Change]:
        """Take a component from its holder. Whether the caller may do that is not checked here.

        Raises:
            OutOfResources: there is no epoch left.
        """
        if self.holding.holder(component_ref) is None:
            return self.request(component_ref, taker, now)
        if self.holding.is_held(component_ref, taker):
            return []
        return self._hand_over(component_ref, taker, now, Why.TAKEN)

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
        """Note that a connection was lost: what a session with a token holds is kept for the grace."""
        if not self._tokens.has_one(holder):
            return self.leave(holder, now)
        self.absent[holder] = now + self.rules.grace
        return [*self._withdraw_all(holder), *(Queued(ref) for ref in self.holding.held_by(holder))]

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
        begun = {} if was_lost else {component_ref: self.holding.next_epoch(component_ref) for component_ref in held}
        self._tokens.succeed(former, successor)
        self.absent.pop(former, None)
        changes = self._withdraw_all(former)
        for component_ref, epoch in held.items():
            request = self.waiting.find(component_ref, successor)
            if request is not None:
                self.waiting.remove(request)
            if was_lost:
                self.holding.succeed(component_ref, successor)
            else:
                gained = self.holding.move(component_ref, successor, begun[component_ref])
                changes.append(Lost(component_ref, former, epoch, Why.RESUMED))
                changes.append(Gained(component_ref, successor, gained, Why.RESUMED))
            queue = self.waiting.queue(component_ref)
            changes.append(Queued(component_ref))
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
        if self.rules.grace <= 0 or self.holding.holder(component_ref) is not None:
            return []
        self.holding.move(component_ref, holder)
        if not self._tokens.has_one(holder):
            self._tokens.issue(holder, subject)
        self.absent[holder] = now + self.rules.grace
        return [Queued(component_ref)]

    def advance(self, now: float) -> list[Change]:
        """Do what is due: graces that are over, and answers that did not come."""
        changes: list[Change] = []
        for holder in [holder for holder, until in self.absent.items() if until <= now]:
            changes += self.leave(holder, now, Why.EXPIRED)
        for request in self.waiting.unanswered():
            if request.deadline is not None and request.deadline <= now:
                request.deadline = None
                changes.append(Declined(request, in_time=False))
        return changes

    # How it is done.

    def _held(self, component_ref: str) -> tuple[object, int]:
        held = self.holding.holder(component_ref)
        assert held is not None, "a free component has no queue"
        return held

    def _asked(self, request_id: str, holder: object) -> Request:
        request = self.waiting.get(request_id)
        if request is None or not self.holding.is_held(request.component_ref, holder):
            raise Unsupported(f"there is no request {request_id[:200]!r}")
        return request

    def _hand_over(self, component_ref: str, successor: object, now: float, why: Why) -> list[Change]:
        held = self._held(component_ref)
        epoch = self.holding.move(component_ref, successor)
        request = self.waiting.find(component_ref, successor)
        if request is not None:
            self.waiting.remove(request)
        changes: list[Change] = [Lost(component_ref, held[0], held[1], why)]
        return [*changes, Gained(component_ref, successor, epoch, why), *self._ask_again(component_ref, now)]

    def _ask_again(self, component_ref: str, now: float) -> list[Change]:
        """Ask a new holder what the former one was asked."""
        queue = self.waiting.queue(component_ref)
        holder, _ = self._held(component_ref)
        for request in queue:
            request.deadline = now + self.rules.patience
        return [*(Asked(request, holder) for request in queue), Queued(component_ref)]

    def _decline_all(self, queue: Iterable[Request], problem: str = "") -> list[Change]:
        """End the waiting for a component: it is gone, unless there is another problem."""
        changes: list[Change] = []
        for request in queue:
            self.waiting.remove(request)
            changes.append(Declined(request, in_time=True, gone=not problem, problem=problem))
        return changes

    def _withdraw_all(self, asker: object) -> list[Change]:
        return [change for request in self.waiting.of(asker) for change in self._withdraw(request)]

    def _withdraw(self, request: Request) -> list[Change]:
        held = self.holding.holder(request.component_ref)
        assert held is not None
        self.waiting.remove(request)
        return [Withdrawn(request, held[0]), Queued(request.component_ref)]
