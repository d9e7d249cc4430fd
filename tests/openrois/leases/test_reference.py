"""The rules of leases against the simplest thing that could be right: parts, queues, loans, lost connections, STOP."""

import math
import os
from itertools import count

import pytest
from hypothesis import HealthCheck, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, precondition, rule, run_state_machine_as_test

from openrois.errors import OutOfResources, Unsupported
from openrois.leases.changes import Asked, Change, Declined, Gained, Lost, NotReturned, Why, Withdrawn
from openrois.leases.model import LeaseModel, Replayed, Rules
from openrois.leases.waiting import Request
from tests.openrois.leases.reference import MEMBERS, REFS, BodyParts, Reference, Session

GRACE, PATIENCE, LOAN = 10.0, 30.0, 20.0


class LeaseMachine(RuleBasedStateMachine):
    """Four applications, a lamp and legs; the model's notifications about holders are added up and compared, too."""

    seats = st.integers(0, 3)
    refs = st.sampled_from(REFS)

    def __init__(self) -> None:
        super().__init__()
        self.now = 0.0
        self.numbers = count()
        self.model = LeaseModel(Rules(GRACE, PATIENCE, LOAN), parts=BodyParts(), may_return=self.may_return)
        self.left: set[Session] = set()
        self.reference = Reference()
        self.sessions = [Session(next(self.numbers)) for _ in range(4)]
        self.gone: list[Session] = []
        self.told: dict[str, tuple[object, int]] = {}
        self.asked: dict[str, Request] = {}
        self.used: list[tuple[str, Session]] = []
        self.last_epoch = 0

    @staticmethod
    def may_return(lender: object, part: str) -> bool:
        assert isinstance(lender, Session)
        assert part in MEMBERS
        return not lender.is_latched

    def live(self, seat: int) -> Session:
        """The application in a seat; if its connection was lost, another one has come and it is forgotten there."""
        if self.sessions[seat].away_until is not None:
            self.gone.append(self.sessions[seat])
            self.sessions[seat] = Session(next(self.numbers))
        return self.sessions[seat]

    def take(self, changes: list[Change]) -> None:
        for change in changes:
            match change:
                case Lost(ref, holder, epoch, _, _):
                    assert self.told.pop(ref) == (holder, epoch)
                case Gained(ref, holder, epoch, why, _):
                    assert ref not in self.told
                    assert holder not in self.left
                    assert why is not Why.RETURNED or not (isinstance(holder, Session) and holder.is_latched)
                    self.begun(ref, holder, epoch)
                    self.drop_asked(ref, holder)
                case NotReturned(_, lender, _, _):
                    assert lender not in self.left
                case Asked(request, holder):
                    assert self.model.holding.holder_of(request.part) is holder
                    self.asked[request.request_id] = request
                case Withdrawn(request) | Declined(request):
                    self.asked.pop(request.request_id, None)

    def drop_asked(self, ref: str, holder: object) -> None:
        """The new holder asks no more."""
        part = BodyParts().part_of(ref)
        for key in [key for key, asked in self.asked.items() if (asked.part, asked.asker) == (part, holder)]:
            del self.asked[key]

    def begun(self, ref: str, holder: object, epoch: int) -> None:
        assert epoch > self.last_epoch
        self.last_epoch = epoch
        self.told[ref] = holder, epoch

    @rule(seat=seats, ref=refs)
    def bind(self, seat: int, ref: str) -> None:
        session = self.live(seat)
        if self.reference.bind(ref, session):
            epoch = self.model.holding.bind(ref, session)
            if ref not in self.told:
                self.begun(ref, session, epoch)
        else:
            with pytest.raises(OutOfResources):
                self.model.holding.bind(ref, session)

    @rule(seat=seats, ref=refs)
    def release(self, seat: int, ref: str) -> None:
        session = self.live(seat)
        self.reference.release(ref, session)
        self.take(self.model.release(ref, session, self.now))

    @rule(seat=seats, ref=refs)
    def hand_back(self, seat: int, ref: str) -> None:
        session = self.live(seat)
        self.reference.hand_back(ref, session)
        self.take(self.model.hand_back(ref, session, self.now))

    @rule(seat=seats, ref=refs, seconds=st.sampled_from((None, 5.0, 40.0)), for_one=st.booleans())
    def borrow(self, seat: int, ref: str, seconds: float | None, for_one: bool) -> None:
        session = self.live(seat)
        self.reference.borrow(ref, session, self.now + (LOAN if seconds is None else seconds), for_one)
        self.take(self.model.borrow(ref, session, self.now, seconds, for_one=for_one))

    @rule(seat=seats, ref=refs)
    def finish(self, seat: int, ref: str) -> None:
        session = self.live(seat)
        self.reference.finish(ref, session)
        self.take(self.model.note_ended(ref, session, self.now))

    @rule(seat=seats, is_latched=st.booleans())
    def stop_or_release(self, seat: int, is_latched: bool) -> None:
        self.live(seat).is_latched = is_latched

    @rule(seat=seats, ref=refs)
    def request(self, seat: int, ref: str) -> None:
        session = self.live(seat)
        self.reference.request(ref, session)
        self.take(self.model.request(ref, session, self.now))

    @rule(seat=seats, ref=refs)
    def withdraw(self, seat: int, ref: str) -> None:
        session = self.live(seat)
        self.reference.withdraw(ref, session)
        self.take(self.model.withdraw(ref, session))

    @rule(seat=seats, which=st.integers(0, 5), yes=st.booleans())
    def answer(self, seat: int, which: int, yes: bool) -> None:
        if not self.asked:
            return
        request = list(self.asked.values())[which % len(self.asked)]
        session, part = self.live(seat), self.reference.parts[request.part]

        def answer() -> list[Change]:
            if yes:
                return self.model.grant(request.request_id, session, self.now)
            return self.model.decline(request.request_id, session)

        if part.holder() is session and request.asker in part.waiting():
            if yes:
                assert isinstance(request.asker, Session)
                self.reference.promote(request.component_ref, request.asker)
                self.asked.pop(request.request_id)
            self.take(answer())
        else:
            with pytest.raises(Unsupported):
                answer()

    @rule(seat=seats, ref=refs)
    def seize(self, seat: int, ref: str) -> None:
        session = self.live(seat)
        self.reference.take(ref, session)
        self.take(self.model.take(ref, session, self.now))

    @rule(seat=seats)
    def ask_for_token(self, seat: int) -> None:
        session = self.live(seat)
        if session.token:
            self.used.append((session.token, session))
        session.token = self.model.token(session, "ann")

    @rule(seat=seats)
    def lose_connection(self, seat: int) -> None:
        session = self.live(seat)
        if session.token:
            self.reference.lose(session)
        else:
            self.forget(session)
        session.away_until = self.now + GRACE
        self.take(self.model.lose(session, self.now))

    @rule(seat=seats)
    def leave(self, seat: int) -> None:
        session = self.live(seat)
        self.forget(session)
        self.sessions[seat] = Session(next(self.numbers))
        self.take(self.model.leave(session, self.now))

    @rule(seat=seats, by=seats, ref=refs, lost=st.booleans(), waits=st.booleans())
    def change_connections(self, seat: int, by: int, ref: str, lost: bool, waits: bool) -> None:
        """The most of what happens with tokens, which single steps seldom come to."""
        former, successor = self.live(seat), self.live(by)
        self.ask_for_token(seat)
        self.bind(seat, ref)
        if waits:
            self.request(by, ref)
        if lost:
            self.lose_connection(seat)
        self.show(former, successor, "ann")

    def with_token(self) -> list[Session]:
        return [session for session in (*self.sessions, *self.gone) if session.token]

    @precondition(lambda self: bool(self.with_token()))
    @rule(which=st.integers(0, 7), by=st.integers(0, 7), subject=st.sampled_from(("ann", "ann", "ann", "bob")))
    def resume(self, which: int, by: int, subject: str) -> None:
        former = self.with_token()[which % len(self.with_token())]
        self.show(former, self.live(by) if by < 4 else Session(next(self.numbers)), subject)

    def show(self, former: Session, successor: Session, subject: str) -> None:
        """The session that shows the token is the holder from then on, lost or not; it may wait meanwhile."""
        if successor is former or self.model.has_any(successor):
            # The gateway asks the model for those alone that hold nothing.
            return
        lost = former.away_until is not None
        if subject == "ann" and (not lost or former in self.model.absent):
            before = dict(self.told)
            resumed, changes = self.model.resume(former.token, subject, successor, self.now)
            assert resumed is former
            assert former not in self.model.absent
            assert not self.model.has_any(former)
            assert self.model.waiting.of(former) == ()
            self.succeed(former, successor, lost=lost)
            self.take(changes)
            for ref, (holder, epoch) in before.items():
                if holder is former:
                    assert self.told[ref][0] is successor
                    # What a lost connection sent cannot come any more; of any other it must be told as late.
                    assert (self.told[ref][1] == epoch) is lost
        else:
            with pytest.raises(Unsupported):
                self.model.resume(former.token, subject, successor, self.now)

    def succeed(self, former: Session, successor: Session, *, lost: bool) -> None:
        held = [ref for ref in REFS if self.reference.holder(ref) is former]
        self.reference.replace(former, successor)
        for ref in held:
            self.drop_asked(ref, successor)
            if lost:
                self.told[ref] = successor, self.told[ref][1]
        self.left.add(former)
        # Its line is that of the former session from now on; its own is dropped.
        self.used = [(token, of) for token, of in self.used if of is not successor]
        self.used = [(token, successor if of is former else of) for token, of in self.used]
        self.used.append((former.token, successor))
        successor.token, former.token = "", ""
        self.sessions = [each for each in self.sessions if each not in (former, successor)] + [successor]
        while len(self.sessions) < 4:
            self.sessions.append(Session(next(self.numbers)))

    @rule(seat=seats)
    def resume_itself(self, seat: int) -> None:
        session = self.live(seat)
        if session.token:
            with pytest.raises(Unsupported, match="resume a former one"):
                self.model.resume(session.token, "ann", session, self.now)

    @rule(which=st.integers(0, 5))
    def replay(self, which: int) -> None:
        if not self.used:
            return
        token, session = self.used[which % len(self.used)]
        with pytest.raises(Unsupported) as refused:
            self.model.resume(token, "ann", Session(-1), self.now)
        if isinstance(refused.value, Replayed):
            assert refused.value.holder is session
            session.token = ""
            if session.away_until is not None:
                self.forget(session)
            self.take(refused.value.changes)

    @rule(seconds=st.sampled_from((1.0, 9.0, 31.0)))
    def wait(self, seconds: float) -> None:
        self.now += seconds
        # In the order in which their connections were lost.
        away = [session for session in (*self.gone, *self.sessions) if session.away_until is not None]
        for session in sorted(away, key=lambda each: each.away_until or 0.0):
            if session.away_until is not None and session.away_until <= self.now:
                self.reference.forget(session)
        self.reference.end_loans(self.now)
        self.take(self.model.advance(self.now))
        due = self.model.next_due()
        assert due is None or due > self.now

    def forget(self, session: Session) -> None:
        self.reference.forget(session)

    @invariant()
    def exactly_one_holds(self) -> None:
        for ref in REFS:
            held = self.model.holding.holder(ref)
            assert held == self.told.get(ref)
            assert (held and held[0]) is self.reference.holder(ref)
        for name, part in self.reference.parts.items():
            holders = {self.told[ref][0] for ref in MEMBERS[name] if ref in self.told}
            assert holders == ({part.holder()} if part.stack else set()), "never two holders of a part"
            assert [request.asker for request in self.model.waiting.queue(name)] == part.waiting()
            places = self.model.loans.lenders(name)
            lenders = [(each.holder, set(each.epochs), set(each.named)) for each in places]
            assert lenders == [(each.session, each.refs, each.named) for each in part.stack[:-1]]
            named = part.stack[-1].named if part.stack else set()
            assert set(self.model.holding.named_of(name)) == named

    @invariant()
    def every_loan_ends(self) -> None:
        for name, part in self.reference.parts.items():
            loan = self.model.loans.of(name)
            until = part.stack[-1].until if part.stack else math.inf
            assert (math.inf if loan is None else loan.until) == until
            assert all(each.until < math.inf for each in part.stack[1:])


def compare(runs: int) -> None:
    chosen = settings(
        max_examples=runs, stateful_step_count=30, deadline=None, database=None, suppress_health_check=list(HealthCheck)
    )
    run_state_machine_as_test(LeaseMachine, settings=chosen)


@pytest.mark.timeout(900)
def test_like_the_reference() -> None:
    """`OPENROIS_LEASE_RUNS=5000` tries many more; that takes some minutes."""
    compare(int(os.environ.get("OPENROIS_LEASE_RUNS", "300")))
