import pytest
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, precondition, rule
from openrois_signaling.messages import CANDIDATES_LIMIT, SDP_LIMIT, Answer, Bye, Candidate, Offer, StreamSection
from openrois_signaling.negotiation import (
    ANSWER_TIMEOUT,
    APPLY_TIMEOUT,
    PREPARE_TIMEOUT,
    TIMEOUTS,
    TRANSITIONS,
    IllegalTransition,
    Input,
    Negotiation,
    State,
    Verdict,
)
from pydantic import ValidationError

PEER = "engine/peer"
SECTIONS = (
    StreamSection(mid="0", stream_id="engine/s", component_ref="engine/Video", kind="video", direction="recvonly"),
)


def answer(generation: int) -> Answer:
    return Answer(peer_id=PEER, generation=generation, sdp="v=0")


def candidate(generation: int, number: int = 0) -> Candidate:
    return Candidate(peer_id=PEER, generation=generation, candidate=f"candidate:{number}", sdp_mid="0")


def offered(now: float = 0.0, *, replaces: str | None = None) -> tuple[Negotiation, Offer]:
    negotiation = Negotiation(PEER, replaces)
    assert negotiation.change(now)
    negotiation.describe()
    return negotiation, negotiation.made("v=0", SECTIONS, now)


def settled() -> Negotiation:
    negotiation, offer = offered()
    assert negotiation.receive_answer(answer(offer.generation), 0.0) is Verdict.APPLY
    assert negotiation.applied(0.0) == ()
    return negotiation


def in_state(state: State) -> Negotiation:
    negotiation = Negotiation(PEER)
    if state is State.ENDED:
        negotiation.end_negotiation("over")
    if state in {State.PREPARING, State.OFFERED, State.APPLYING}:
        negotiation.change(0.0)
    if state in {State.OFFERED, State.APPLYING}:
        negotiation.made("v=0", SECTIONS, 0.0)
    if state is State.APPLYING:
        negotiation.receive_answer(answer(1), 0.0)
    assert negotiation.state is state
    return negotiation


def feed(negotiation: Negotiation, event: Input) -> None:
    match event:
        case Input.CHANGE:
            negotiation.change(1.0)
        case Input.MADE:
            negotiation.made("v=0", SECTIONS, 1.0)
        case Input.ANSWER:
            negotiation.receive_answer(answer(max(1, negotiation.generation)), 1.0)
        case Input.APPLIED:
            negotiation.applied(1.0)
        case Input.END:
            negotiation.end_negotiation("over")


@pytest.mark.parametrize("state", State)
@pytest.mark.parametrize("event", Input)
def test_every_input_in_every_state_does_what_the_table_says(state: State, event: Input) -> None:
    negotiation = in_state(state)
    if event in TRANSITIONS[state]:
        feed(negotiation, event)
        assert negotiation.state is TRANSITIONS[state][event]
        return
    if event in {Input.CHANGE, Input.MADE, Input.APPLIED}:
        with pytest.raises(IllegalTransition, match=f"{event.value} while {state.value}"):
            feed(negotiation, event)
    else:
        feed(negotiation, event)
    assert negotiation.state is state


def test_the_table_is_whole_and_ends_everywhere() -> None:
    assert set(TRANSITIONS) == set(State)
    assert all(Input.END in TRANSITIONS[state] for state in State if state is not State.ENDED)


def test_an_offer_is_made_sent_answered_and_applied() -> None:
    negotiation, offer = offered()
    assert offer == Offer(peer_id=PEER, generation=1, sdp="v=0", streams=SECTIONS)
    assert negotiation.receive_answer(answer(1), 3.0) is Verdict.APPLY
    assert negotiation.answered == 0
    assert negotiation.applied(3.0) == ()
    assert (negotiation.state, negotiation.answered, negotiation.dirty) == (State.STABLE, 1, False)


def test_a_replacement_names_the_peer_it_replaces_in_its_first_offer_only() -> None:
    negotiation, first = offered(replaces="engine/old")
    assert first.replaces == "engine/old"
    negotiation.receive_answer(answer(1), 0.0)
    negotiation.applied(0.0)
    assert negotiation.change(0.0)
    assert negotiation.made("v=0", (), 0.0).replaces is None


@pytest.mark.parametrize("state", [State.PREPARING, State.OFFERED, State.APPLYING])
def test_a_change_while_an_offer_is_pending_goes_into_the_next_one(state: State) -> None:
    negotiation = in_state(state)
    assert not negotiation.change(0.0)
    assert not negotiation.change(0.0)
    if state is State.PREPARING:
        negotiation.made("v=0", SECTIONS, 0.0)
    if state is not State.APPLYING:
        negotiation.receive_answer(answer(1), 0.0)
    negotiation.applied(0.0)
    dirty = [negotiation.dirty]
    assert negotiation.change(0.0)
    dirty.append(negotiation.dirty)
    assert dirty == [True, False]
    assert negotiation.made("v=0", SECTIONS, 0.0).generation == 2


def test_a_change_before_the_sections_are_read_is_in_that_description() -> None:
    negotiation = in_state(State.PREPARING)
    negotiation.change(0.0)
    negotiation.describe()
    dirty = [negotiation.dirty]
    negotiation.change(0.0)
    negotiation.made("v=0", SECTIONS, 0.0)
    dirty.append(negotiation.dirty)
    assert dirty == [False, True]
    with pytest.raises(IllegalTransition):
        negotiation.describe()


@pytest.mark.parametrize("generation", [1, 3])
def test_a_stale_answer_is_dropped_and_says_so(generation: int) -> None:
    negotiation = settled()
    negotiation.change(0.0)
    negotiation.made("v=0", SECTIONS, 0.0)
    assert negotiation.receive_answer(answer(generation), 0.0) is Verdict.STALE
    assert negotiation.state is State.OFFERED
    assert negotiation.receive_answer(answer(2), 0.0) is Verdict.APPLY


def test_a_second_answer_to_the_same_offer_is_stale() -> None:
    negotiation = settled()
    assert negotiation.receive_answer(answer(1), 0.0) is Verdict.STALE


def test_what_is_wrong_with_an_answer_that_no_offer_waits_for() -> None:
    negotiation = settled()
    answered, unknown = "the offer of generation 1 has been answered already", "there was no offer of generation 2"
    assert [negotiation.why_stale(answer(number)) for number in (1, 2)] == [answered, unknown]
    negotiation.change(0.0)
    assert negotiation.why_stale(answer(2)) == unknown
    negotiation.made("v=0", SECTIONS, 0.0)
    awaited = "that of generation 2 awaits its answer"
    assert negotiation.why_stale(answer(1)) == f"{answered}; {awaited}"
    assert negotiation.why_stale(answer(3)) == f"there was no offer of generation 3; {awaited}"


def test_candidates_wait_for_the_description_they_belong_to() -> None:
    negotiation, _ = offered()
    early = [candidate(1, number) for number in range(3)]
    assert [negotiation.candidate(each) for each in early[:2]] == [Verdict.HELD, Verdict.HELD]
    negotiation.receive_answer(answer(1), 0.0)
    assert negotiation.candidate(early[2]) is Verdict.HELD
    assert negotiation.applied(0.0) == tuple(early)
    assert negotiation.candidate(candidate(1, 4)) is Verdict.APPLY


def test_a_candidate_of_the_answer_in_place_is_good_while_a_further_offer_is_out() -> None:
    negotiation = settled()
    negotiation.change(0.0)
    negotiation.made("v=0", SECTIONS, 0.0)
    assert negotiation.candidate(candidate(1)) is Verdict.APPLY
    assert negotiation.candidate(candidate(2)) is Verdict.HELD
    negotiation.receive_answer(answer(2), 0.0)
    assert negotiation.applied(0.0) == (candidate(2),)
    assert negotiation.candidate(candidate(1)) is Verdict.STALE
    assert negotiation.candidate(candidate(3)) is Verdict.STALE


def test_a_candidate_before_the_first_offer_is_stale() -> None:
    assert Negotiation(PEER).candidate(candidate(1)) is Verdict.STALE


def test_a_peer_sends_a_bounded_number_of_candidates() -> None:
    negotiation, _ = offered()
    for number in range(CANDIDATES_LIMIT // 2):
        assert negotiation.candidate(candidate(1, number)) is Verdict.HELD
    negotiation.receive_answer(answer(1), 0.0)
    assert len(negotiation.applied(0.0)) == CANDIDATES_LIMIT // 2
    for number in range(CANDIDATES_LIMIT // 2):
        assert negotiation.candidate(candidate(1, number)) is Verdict.APPLY
    assert negotiation.candidate(candidate(1)) is Verdict.FULL


@pytest.mark.parametrize(
    ("state", "limit"),
    [(State.PREPARING, PREPARE_TIMEOUT), (State.OFFERED, ANSWER_TIMEOUT), (State.APPLYING, APPLY_TIMEOUT)],
)
def test_what_takes_too_long_ends_the_peer(state: State, limit: float) -> None:
    negotiation = in_state(state)
    assert negotiation.deadline() == limit
    assert negotiation.expire(limit - 0.001) is None
    assert negotiation.expire(limit) == Bye(peer_id=PEER, reason=TIMEOUTS[state][1])
    assert negotiation.state is State.ENDED
    assert negotiation.expire(limit) is None


def test_an_unanswered_stream_is_given_back_after_fifteen_seconds_at_most() -> None:
    assert PREPARE_TIMEOUT + ANSWER_TIMEOUT == 15.0


def test_a_change_does_not_move_the_deadline_of_the_offer() -> None:
    negotiation, _ = offered(now=100.0)
    negotiation.change(105.0)
    assert negotiation.deadline() == 110.0


@pytest.mark.parametrize("state", list(TIMEOUTS))
def test_a_pause_of_the_process_does_not_count(state: State) -> None:
    negotiation = in_state(state)
    negotiation.excuse(20.0, 22.0)
    assert negotiation.expire(22.0) is None
    assert negotiation.deadline() == 20.0 + TIMEOUTS[state][0]
    negotiation.excuse(20.0, 22.0)
    assert negotiation.deadline() == 22.0 + TIMEOUTS[state][0]


@pytest.mark.parametrize("state", [State.STABLE, State.ENDED])
def test_nothing_is_due_while_nothing_is_awaited(state: State) -> None:
    negotiation = in_state(state)
    assert negotiation.deadline() is None
    assert negotiation.expire(1e9) is None
    assert negotiation.state is state


def test_an_end_is_for_good_and_said_once() -> None:
    negotiation, _ = offered()
    negotiation.candidate(candidate(1))
    assert negotiation.end_negotiation("rejected") == Bye(peer_id=PEER, reason="rejected")
    assert negotiation.end_negotiation("again") is None
    assert negotiation.receive_answer(answer(1), 0.0) is Verdict.ENDED
    assert negotiation.candidate(candidate(1)) is Verdict.ENDED


def test_a_description_that_exceeds_the_limits_changes_nothing() -> None:
    negotiation = in_state(State.PREPARING)
    with pytest.raises(ValidationError):
        negotiation.made("x" * (SDP_LIMIT + 1), SECTIONS, 0.0)
    assert (negotiation.state, negotiation.generation) == (State.PREPARING, 0)
    assert negotiation.made("v=0", SECTIONS, 0.0).generation == 1


def _generation(candidate: Candidate) -> int:
    return candidate.generation


class Conversation(RuleBasedStateMachine):
    """Any order of what both ends may do, against the promises of the wire."""

    @initialize(replaces=st.sampled_from([None, "engine/old"]))
    def begin(self, replaces: str | None) -> None:
        self.negotiation = Negotiation(PEER, replaces)
        self.replaces = replaces
        self.now = 0.0
        self.number = 0
        self.unanswered: Offer | None = None
        self.unsaid = False
        self.byes = 0
        self.accepted: list[Candidate] = []
        self.added: list[Candidate] = []

    @property
    def ended(self) -> bool:
        return self.negotiation.state is State.ENDED

    @rule(seconds=st.sampled_from([0.0, 0.5, 4.0, 11.0]))
    def wait(self, seconds: float) -> None:
        self.now += seconds
        deadline = self.negotiation.deadline()
        bye = self.negotiation.expire(self.now)
        assert (bye is not None) == (deadline is not None and deadline <= self.now)
        self.byes += bye is not None

    @precondition(lambda self: not self.ended)
    @rule()
    def change(self) -> None:
        busy = self.negotiation.state is not State.STABLE
        assert self.negotiation.change(self.now) is not busy
        self.unsaid = busy

    @precondition(lambda self: self.negotiation.state is State.PREPARING)
    @rule()
    def make(self) -> None:
        assert self.unanswered is None
        before = self.negotiation.generation
        self.negotiation.describe()
        self.unsaid = False
        self.unanswered = self.negotiation.made("v=0", SECTIONS, self.now)
        assert self.unanswered.generation == before + 1
        assert self.unanswered.replaces == (self.replaces if before == 0 else None)

    @rule(behind=st.integers(-1, 2))
    def send_answer(self, behind: int) -> None:
        generation = max(1, self.negotiation.generation - behind)
        due = self.unanswered is not None and self.unanswered.generation == generation and not self.ended
        verdict = self.negotiation.receive_answer(answer(generation), self.now)
        assert (verdict is Verdict.APPLY) == due
        if verdict is Verdict.APPLY:
            self.unanswered = None

    @precondition(lambda self: self.negotiation.state is State.APPLYING)
    @rule()
    def apply(self) -> None:
        self.added += self.negotiation.applied(self.now)
        # Those of the answer in place overtake those that wait for the next one.
        assert sorted(self.added, key=_generation) == sorted(self.accepted, key=_generation)
        assert self.negotiation.dirty == self.unsaid

    @rule(behind=st.integers(-1, 2))
    def send_candidate(self, behind: int) -> None:
        self.number += 1
        sent = candidate(max(1, self.negotiation.generation - behind), self.number)
        match self.negotiation.candidate(sent):
            case Verdict.APPLY:
                assert sent.generation == self.negotiation.answered
                self.added.append(sent)
                self.accepted.append(sent)
            case Verdict.HELD:
                assert sent.generation == self.negotiation.generation > self.negotiation.answered
                self.accepted.append(sent)
            case Verdict.STALE:
                assert not self.negotiation.answered <= sent.generation <= self.negotiation.generation
            case verdict:
                assert self.ended or len(self.accepted) == CANDIDATES_LIMIT
                assert verdict in {Verdict.ENDED, Verdict.FULL}

    @rule()
    def leave(self) -> None:
        over = self.ended
        assert (self.negotiation.end_negotiation("left") is None) == over
        self.byes += not over

    @invariant()
    def promises(self) -> None:
        state = self.negotiation.state
        assert self.byes == (state is State.ENDED)
        assert self.negotiation.answered <= self.negotiation.generation <= self.negotiation.answered + 1
        assert (self.negotiation.deadline() is None) == (state in {State.STABLE, State.ENDED})
        assert len(self.accepted) <= CANDIDATES_LIMIT
        if self.unanswered is not None and state is not State.ENDED:
            assert state is State.OFFERED


Conversation.TestCase.settings = settings(max_examples=40, stateful_step_count=25, deadline=None)
TestConversation = Conversation.TestCase
