"""The rules of leases: each by itself, and all of them against the simplest thing that could be right."""

import os
from dataclasses import dataclass, field
from itertools import count

import pytest
from hypothesis import HealthCheck, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, precondition, rule, run_state_machine_as_test

from openrois.errors import OutOfResources, Unsupported
from openrois.leases.changes import Asked, Change, Declined, Gained, Lost, Queued, Why, Withdrawn
from openrois.leases.epochs import ClaimedEpochs
from openrois.leases.model import LeaseModel, Replayed, Rules
from openrois.leases.waiting import MAX_WAITING, Request

GRACE, PATIENCE = 10.0, 30.0
LAMP, ARM = "r/lamp", "r/arm"


@dataclass(eq=False)
class Session:
    """One application, or another that has come in its place."""

    number: int
    token: str = ""
    away_until: float | None = None

    def __repr__(self) -> str:
        return f"session {self.number}"


@dataclass
class Reference:
    """Plain lists of holders and of requests; the head of each is the holder. Nothing else is kept."""

    lines: dict[str, list[Session]] = field(default_factory=lambda: {LAMP: [], ARM: []})

    def holder(self, ref: str) -> Session | None:
        return self.lines[ref][0] if self.lines[ref] else None

    def bind(self, ref: str, session: Session) -> bool:
        if not self.lines[ref]:
            self.lines[ref] = [session]
        return self.holder(ref) is session

    def request(self, ref: str, session: Session) -> None:
        if session not in self.lines[ref]:
            self.lines[ref].append(session)

    def drop(self, ref: str, session: Session) -> None:
        self.lines[ref] = [other for other in self.lines[ref] if other is not session]

    def replace(self, ref: str, former: Session, successor: Session, *, lost: bool) -> None:
        """One goes on where another ended: it holds what that one held, and waits for nothing that it holds now."""
        if self.holder(ref) is former:
            self.lines[ref] = [successor, *(other for other in self.lines[ref][1:] if other is not successor)]
        elif not lost:
            self.drop(ref, former)

    def promote(self, ref: str, session: Session) -> None:
        if self.holder(ref) is not session:
            self.lines[ref] = [session, *(other for other in self.lines[ref][1:] if other is not session)]


class LeaseMachine(RuleBasedStateMachine):
    """Four applications and two components; the model's notifications about holders are added up and compared, too."""

    seats = st.integers(0, 3)
    refs = st.sampled_from((LAMP, ARM))

    def __init__(self) -> None:
        super().__init__()
        self.now = 0.0
        self.numbers = count()
        self.model = LeaseModel(Rules(GRACE, PATIENCE))
        self.reference = Reference()
        self.sessions = [Session(next(self.numbers)) for _ in range(4)]
        self.gone: list[Session] = []
        self.told: dict[str, tuple[object, int]] = {}
        self.asked: dict[str, Request] = {}
        self.used: list[tuple[str, Session]] = []
        self.last_epoch = 0

    def live(self, seat: int) -> Session:
        """The application in a seat; if its connection was lost, another one has come and it is forgotten there."""
        if self.sessions[seat].away_until is not None:
            self.gone.append(self.sessions[seat])
            self.sessions[seat] = Session(next(self.numbers))
        return self.sessions[seat]

    def take(self, changes: list[Change]) -> None:
        for change in changes:
            match change:
                case Lost(ref, holder, epoch):
                    assert self.told.pop(ref) == (holder, epoch)
                case Gained(ref, holder, epoch):
                    assert ref not in self.told
                    self.begun(ref, holder, epoch)
                    # The new holder asks no more.
                    done = [
                        key for key, asked in self.asked.items() if (asked.component_ref, asked.asker) == (ref, holder)
                    ]
                    for key in done:
                        del self.asked[key]
                case Asked(request, holder):
                    assert self.model.holding.is_held(request.component_ref, holder)
                    self.asked[request.request_id] = request
                case Withdrawn(request) | Declined(request):
                    self.asked.pop(request.request_id, None)

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
        if self.reference.holder(ref) is session:
            self.reference.drop(ref, session)
        self.take(self.model.release(ref, session, self.now))

    @rule(seat=seats, ref=refs)
    def request(self, seat: int, ref: str) -> None:
        session = self.live(seat)
        self.reference.request(ref, session)
        self.take(self.model.request(ref, session, self.now))

    @rule(seat=seats, ref=refs)
    def withdraw(self, seat: int, ref: str) -> None:
        session = self.live(seat)
        if self.reference.holder(ref) is not session:
            self.reference.drop(ref, session)
        self.take(self.model.withdraw(ref, session))

    @rule(seat=seats, which=st.integers(0, 5), yes=st.booleans())
    def answer(self, seat: int, which: int, yes: bool) -> None:
        if not self.asked:
            return
        request = list(self.asked.values())[which % len(self.asked)]
        session, ref = self.live(seat), request.component_ref

        def answer() -> list[Change]:
            if yes:
                return self.model.grant(request.request_id, session, self.now)
            return self.model.decline(request.request_id, session)

        if self.reference.holder(ref) is session and request.asker in self.reference.lines[ref][1:]:
            if yes:
                assert isinstance(request.asker, Session)
                self.reference.promote(ref, request.asker)
                self.asked.pop(request.request_id)
            self.take(answer())
        else:
            with pytest.raises(Unsupported):
                answer()

    @rule(seat=seats, ref=refs)
    def seize(self, seat: int, ref: str) -> None:
        session = self.live(seat)
        self.reference.promote(ref, session)
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
        for ref in (LAMP, ARM):
            if not session.token or self.reference.holder(ref) is not session:
                self.reference.drop(ref, session)
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
        if successor is former or self.model.holding.held_by(successor):
            # The gateway asks the model for those alone that hold nothing.
            return
        lost = former.away_until is not None
        if subject == "ann" and (not lost or former in self.model.absent):
            before = dict(self.told)
            resumed, changes = self.model.resume(former.token, subject, successor, self.now)
            assert resumed is former
            assert former not in self.model.absent
            assert self.model.holding.held_by(former) == {}
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
        for ref in (LAMP, ARM):
            held = self.reference.holder(ref) is former
            self.reference.replace(ref, former, successor, lost=lost)
            if held and lost:
                self.told[ref] = successor, self.told[ref][1]
            if held:
                asked = [key for key, of in self.asked.items() if (of.component_ref, of.asker) == (ref, successor)]
                for key in asked:
                    del self.asked[key]
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
        for session in list(self.sessions):
            if session.away_until is not None and session.away_until <= self.now:
                self.forget(session)
        for line in [*self.reference.lines.values()]:
            for session in list(line):
                if session.away_until is not None and session.away_until <= self.now:
                    self.forget(session)
        self.take(self.model.advance(self.now))
        due = self.model.next_due()
        assert due is None or due > self.now

    def forget(self, session: Session) -> None:
        for ref in (LAMP, ARM):
            self.reference.drop(ref, session)

    @invariant()
    def exactly_one_holds(self) -> None:
        for ref, line in self.reference.lines.items():
            held = self.model.holding.holder(ref)
            assert held == self.told.get(ref)
            assert (held and held[0]) is (line[0] if line else None)
            assert [request.asker for request in self.model.waiting.queue(ref)] == line[1:]


def compare(runs: int) -> None:
    chosen = settings(
        max_examples=runs, stateful_step_count=30, deadline=None, database=None, suppress_health_check=list(HealthCheck)
    )
    run_state_machine_as_test(LeaseMachine, settings=chosen)


@pytest.mark.timeout(900)
def test_like_the_reference() -> None:
    """`OPENROIS_LEASE_RUNS=5000` tries many more; that takes a minute."""
    compare(int(os.environ.get("OPENROIS_LEASE_RUNS", "300")))


ANN, BOB, EVE = "ann", "bob", "eve"


@pytest.fixture
def model() -> LeaseModel:
    made = LeaseModel(Rules(GRACE, PATIENCE))
    made.holding.bind(LAMP, ANN)
    return made


def asked(changes: list[Change]) -> Request:
    (change,) = (change for change in changes if isinstance(change, Asked))
    return change.request


def test_a_silent_holder_keeps_it_and_may_be_asked_again(model: LeaseModel) -> None:
    request = asked(model.request(LAMP, BOB, 0))
    assert model.request(LAMP, BOB, 1) == []
    assert model.next_due() == PATIENCE
    assert model.advance(PATIENCE - 1) == []
    assert model.advance(PATIENCE) == [Declined(request, in_time=False)]
    assert (model.next_due(), model.waiting.queue(LAMP)) == (None, (request,))
    assert asked(model.request(LAMP, BOB, PATIENCE)) is request
    assert model.decline(request.request_id, ANN) == [Declined(request, in_time=True)]
    assert model.release(LAMP, ANN, 50) == [
        Lost(LAMP, ANN, 1, Why.RELEASED),
        Gained(LAMP, BOB, 2, Why.RELEASED),
        Queued(LAMP),
    ]


def test_the_holder_need_not_request_it(model: LeaseModel) -> None:
    assert model.request(LAMP, ANN, 0) == []
    assert model.take(LAMP, ANN, 0) == []
    assert model.take(ARM, BOB, 0) == [Gained(ARM, BOB, 2, Why.BOUND)]
    assert model.withdraw(LAMP, BOB) == []


def test_so_many_wait(model: LeaseModel) -> None:
    for number in range(MAX_WAITING):
        model.request(LAMP, number, 0)
    with pytest.raises(OutOfResources, match="16 applications wait"):
        model.request(LAMP, BOB, 0)


def test_a_component_that_is_gone_is_waited_for_no_more(model: LeaseModel) -> None:
    request = asked(model.request(LAMP, BOB, 0))
    assert model.end_all({ARM}) == []
    assert model.end_all({LAMP}) == [Lost(LAMP, ANN, 1, Why.GONE), Declined(request, in_time=True, gone=True)]
    assert model.waiting.queue(LAMP) == ()


def test_a_holder_that_is_back_is_asked_what_it_missed(model: LeaseModel) -> None:
    token = model.token(ANN, "ann")
    assert model.lose(ANN, 0) == [Queued(LAMP)]
    first, second = asked(model.request(LAMP, BOB, 0)), asked(model.request(LAMP, EVE, 0))
    model.decline(second.request_id, ANN)
    assert model.resume(token, "ann", "ann again", 1) == (ANN, [Queued(LAMP), Asked(first, "ann again")])
    assert model.holding.held_by("ann again") == {LAMP: 1}


def test_where_there_is_no_grace_there_is_no_token() -> None:
    with pytest.raises(Unsupported):
        LeaseModel(Rules(grace=0)).token(ANN, "ann")


def test_a_token_that_comes_twice_ends_the_grace_of_both(model: LeaseModel) -> None:
    token = model.token(ANN, "ann")
    model.lose(ANN, 0)
    model.resume(token, "ann", BOB, 1)
    model.token(BOB, "ann")
    model.lose(BOB, 2)
    with pytest.raises(Replayed) as replayed:
        model.resume(token, "ann", EVE, 3)
    assert (replayed.value.holder, replayed.value.changes) == (BOB, [Lost(LAMP, BOB, 1, Why.EXPIRED)])


def test_a_session_that_is_still_there_is_put_out(model: LeaseModel) -> None:
    token = model.token(ANN, "ann")
    model.holding.bind(ARM, EVE)
    wanted, waited = asked(model.request(ARM, ANN, 0)), asked(model.request(LAMP, EVE, 0))
    assert model.resume(token, "ann", BOB, 1) == (
        ANN,
        [
            Withdrawn(wanted, EVE),
            Queued(ARM),
            Lost(LAMP, ANN, 1, Why.RESUMED),
            Gained(LAMP, BOB, 3, Why.RESUMED),
            Queued(LAMP),
            Asked(waited, BOB),
        ],
    )
    # What comes of it yet changes nothing.
    assert model.release(LAMP, ANN, 2) == []
    assert model.lose(ANN, 2) == []
    assert model.holding.held_by(BOB) == {LAMP: 3}


def test_resuming_withdraws_requests_for_what_is_held_now(model: LeaseModel) -> None:
    token = model.token(ANN, "ann")
    model.request(LAMP, BOB, 0)
    model.resume(token, "ann", BOB, 1)
    assert model.waiting.queue(LAMP) == ()
    with pytest.raises(Unsupported, match="resume a former one"):
        model.resume(model.token(BOB, "ann"), "ann", BOB, 1)


class TestNoEpochLeft:
    """An engine whose block is used up: nothing changes by half, and what has to be let go is let go."""

    @pytest.fixture
    def model(self) -> LeaseModel:
        epochs = ClaimedEpochs(lambda: "the store is away")
        epochs.grant("r", 1, 1)
        made = LeaseModel(Rules(GRACE, PATIENCE), epochs)
        made.holding.bind(LAMP, ANN)
        return made

    def test_a_free_component_is_not_had(self, model: LeaseModel) -> None:
        with pytest.raises(OutOfResources, match="the store is away"):
            model.holding.bind(ARM, BOB)
        with pytest.raises(OutOfResources, match="the store is away"):
            model.request(ARM, BOB, 0)
        assert model.holding.held() == {LAMP}

    def test_a_hand_over_is_refused_and_the_queue_stays(self, model: LeaseModel) -> None:
        request = asked(model.request(LAMP, BOB, 0))
        with pytest.raises(OutOfResources, match="the store is away"):
            model.grant(request.request_id, ANN, 1)
        with pytest.raises(OutOfResources, match="the store is away"):
            model.take(LAMP, BOB, 1)
        assert model.holding.is_held(LAMP, ANN)
        assert model.waiting.queue(LAMP) == (request,)

    def test_a_release_ends_the_waiting_with_the_reason(self, model: LeaseModel) -> None:
        requests = [asked(model.request(LAMP, asker, 0)) for asker in (BOB, EVE)]
        lost, *declined = model.release(LAMP, ANN, 1)
        assert lost == Lost(LAMP, ANN, 1, Why.RELEASED)
        assert [(each.request, each.gone) for each in declined if isinstance(each, Declined)] == [
            (request, False) for request in requests
        ]
        assert all(isinstance(each, Declined) and "the store is away" in each.problem for each in declined)
        assert (model.holding.held(), model.waiting.queue(LAMP)) == (frozenset(), ())

    def test_a_session_that_is_still_there_is_not_put_out_and_its_token_stays(self, model: LeaseModel) -> None:
        token = model.token(ANN, "ann")
        with pytest.raises(OutOfResources):
            model.resume(token, "ann", BOB, 1)
        assert model.holding.is_held(LAMP, ANN)
        model.lose(ANN, 2)
        assert model.resume(token, "ann", BOB, 3) == (ANN, [Queued(LAMP)])
        assert model.holding.held_by(BOB) == {LAMP: 1}
