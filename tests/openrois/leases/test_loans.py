"""Parts change hands whole, and what is taken for a time comes back: each rule by itself."""

import pytest

from openrois.errors import OutOfResources
from openrois.leases.changes import Asked, Change, Gained, Lost, NotReturned, Queued, Why
from openrois.leases.epochs import ClaimedEpochs
from openrois.leases.model import LOAN, LeaseModel, Rules
from openrois.leases.waiting import Request
from tests.openrois.leases.reference import DRIVE, LAMP, LEGS, WALK, BodyParts

ANN, BOB, EVE = "ann", "bob", "eve"


@pytest.fixture
def stopped() -> set[object]:
    """The sessions to which nothing comes back now."""
    return set()


@pytest.fixture
def model(stopped: set[object]) -> LeaseModel:
    return LeaseModel(Rules(10, 30), parts=BodyParts(), may_return=lambda lender, _part: lender not in stopped)


def holders(model: LeaseModel) -> dict[str, object]:
    held = {ref: model.holding.holder(ref) for ref in (WALK, DRIVE)}
    return {ref: now[0] for ref, now in held.items() if now is not None}


def asked(changes: list[Change]) -> Request:
    (change,) = (change for change in changes if isinstance(change, Asked))
    return change.request


class TestParts:
    def test_a_request_has_all_of_a_part_in_one_step(self, model: LeaseModel) -> None:
        assert model.request(WALK, ANN, 0) == [
            Gained(WALK, ANN, 1, Why.BOUND),
            Gained(DRIVE, ANN, 2, Why.BOUND),
        ]

    def test_one_component_bound_keeps_the_others_from_everybody_else(self, model: LeaseModel) -> None:
        model.holding.bind(WALK, ANN)
        with pytest.raises(OutOfResources, match="r/drive is of the same part as r/walk"):
            model.holding.bind(DRIVE, BOB)
        model.holding.bind(DRIVE, ANN)
        model.release(WALK, ANN, 0)
        with pytest.raises(OutOfResources, match="same part as r/drive"):
            model.holding.bind(WALK, BOB)
        model.release(DRIVE, ANN, 0)
        model.holding.bind(WALK, BOB)

    def test_what_was_accepted_before_does_not_begin_beside_another_holder(self, model: LeaseModel) -> None:
        model.holding.bind(WALK, ANN)
        model.release(WALK, ANN, 0)
        assert not model.holding.is_held_by_another(WALK, ANN)
        model.holding.bind(DRIVE, BOB)
        assert model.holding.is_held_by_another(WALK, ANN)
        assert not model.holding.is_held_by_another(WALK, BOB)

    def test_what_was_had_by_one_name_goes_with_it(self, model: LeaseModel) -> None:
        model.request(WALK, ANN, 0)
        assert [type(change) for change in model.release(WALK, ANN, 1)] == [Lost, Lost]
        assert holders(model) == {}

    def test_what_was_named_too_stays(self, model: LeaseModel) -> None:
        model.request(WALK, ANN, 0)
        model.holding.bind(DRIVE, ANN)
        assert model.release(WALK, ANN, 1) == [Lost(WALK, ANN, 1, Why.RELEASED)]
        assert holders(model) == {DRIVE: ANN}

    def test_the_next_in_line_has_all_of_it(self, model: LeaseModel) -> None:
        model.holding.bind(WALK, ANN)
        request = asked(model.request(DRIVE, BOB, 0))
        assert request.part == LEGS
        assert model.release(WALK, ANN, 1) == [
            Lost(WALK, ANN, 1, Why.RELEASED),
            Gained(DRIVE, BOB, 2, Why.RELEASED),
            Gained(WALK, BOB, 3, Why.RELEASED),
            Queued(DRIVE),
            Queued(WALK),
        ]

    def test_another_part_is_no_concern(self, model: LeaseModel) -> None:
        model.request(WALK, ANN, 0)
        model.holding.bind(LAMP, BOB)
        assert model.holding.is_held(LAMP, BOB)

    def test_none_has_moved_where_one_has_no_epoch(self) -> None:
        epochs = ClaimedEpochs(lambda: "the store is away")
        epochs.grant("r", 1, 2)
        model = LeaseModel(Rules(), epochs, parts=BodyParts())
        model.holding.bind(WALK, ANN)
        with pytest.raises(OutOfResources, match="the store is away"):
            model.borrow(WALK, BOB, 0)
        with pytest.raises(OutOfResources, match="the store is away"):
            model.take(WALK, BOB, 0)
        assert (holders(model), model.loans.count()) == ({WALK: ANN}, 0)

    def test_of_a_part_that_is_partly_gone_the_rest_goes_on(self, model: LeaseModel) -> None:
        model.holding.bind(WALK, ANN)
        model.request(DRIVE, BOB, 0)
        lost, *gained = model.end_all({WALK}, 1)
        assert lost == Lost(WALK, ANN, 1, Why.GONE)
        assert Gained(DRIVE, BOB, 2, Why.GONE) in gained


class TestLoans:
    @pytest.fixture(autouse=True)
    def held(self, model: LeaseModel) -> None:
        model.request(WALK, ANN, 0)

    def test_it_comes_back_in_new_epochs_when_it_is_given_back(self, model: LeaseModel) -> None:
        assert model.borrow(WALK, BOB, 1) == [
            Lost(WALK, ANN, 1, Why.LENT),
            Lost(DRIVE, ANN, 2, Why.LENT),
            Gained(WALK, BOB, 3, Why.LENT, on_loan=True),
            Gained(DRIVE, BOB, 4, Why.LENT, on_loan=True),
            Queued(WALK),
            Queued(DRIVE),
        ]
        assert model.next_due() == 1 + LOAN
        assert model.hand_back(DRIVE, BOB, 2) == [
            Lost(WALK, BOB, 3, Why.RELEASED, on_loan=True),
            Lost(DRIVE, BOB, 4, Why.RELEASED, on_loan=True),
            Gained(WALK, ANN, 5, Why.RETURNED),
            Gained(DRIVE, ANN, 6, Why.RETURNED),
            Queued(WALK),
            Queued(DRIVE),
        ]
        assert model.next_due() is None

    def test_it_comes_back_at_its_time(self, model: LeaseModel) -> None:
        model.borrow(WALK, BOB, 1, 5)
        assert model.advance(5.9) == []
        assert Lost(WALK, BOB, 3, Why.DUE, on_loan=True) in model.advance(6)
        assert holders(model) == {WALK: ANN, DRIVE: ANN}

    def test_to_take_it_again_makes_it_last_longer(self, model: LeaseModel) -> None:
        model.borrow(WALK, BOB, 1, 5)
        assert model.borrow(DRIVE, BOB, 5, 5) == [Queued(WALK), Queued(DRIVE)]
        assert model.advance(9.9) == []
        assert model.advance(10) != []

    def test_it_comes_back_when_the_borrower_is_lost_token_or_not(self, model: LeaseModel) -> None:
        model.borrow(WALK, BOB, 1)
        token = model.token(BOB, "bob")
        model.lose(BOB, 2)
        assert holders(model) == {WALK: ANN, DRIVE: ANN}
        model.resume(token, "bob", "bob again", 3)
        assert holders(model) == {WALK: ANN, DRIVE: ANN}

    def test_one_that_has_left_gets_nothing(self, model: LeaseModel) -> None:
        model.borrow(WALK, BOB, 1)
        assert model.leave(ANN, 2) == []
        assert [type(change) for change in model.release(WALK, BOB, 3)] == [Lost, Lost]
        assert holders(model) == {}

    def test_one_whose_connection_was_lost_gets_it_in_its_grace(self, model: LeaseModel) -> None:
        token = model.token(ANN, "ann")
        model.borrow(WALK, BOB, 1, 5)
        model.lose(ANN, 2)
        model.advance(6)
        assert holders(model) == {WALK: ANN, DRIVE: ANN}
        model.resume(token, "ann", "ann again", 7)
        assert holders(model) == {WALK: "ann again", DRIVE: "ann again"}

    def test_one_that_goes_on_over_another_connection_keeps_its_place(self, model: LeaseModel) -> None:
        token = model.token(ANN, "ann")
        model.borrow(WALK, BOB, 1, 5)
        model.resume(token, "ann", "ann again", 2)
        model.advance(6)
        assert holders(model) == {WALK: "ann again", DRIVE: "ann again"}

    def test_nothing_comes_back_while_stop_is_latched(self, model: LeaseModel, stopped: set[object]) -> None:
        model.borrow(WALK, BOB, 1)
        stopped.add(ANN)
        assert model.release(WALK, BOB, 2)[-2:] == [
            NotReturned(WALK, ANN, 1, Why.LATCHED),
            NotReturned(DRIVE, ANN, 2, Why.LATCHED),
        ]
        assert holders(model) == {}

    def test_a_lender_may_give_up_what_it_lent(self, model: LeaseModel) -> None:
        model.borrow(WALK, BOB, 1)
        assert model.release(WALK, ANN, 2)[:2] == [
            NotReturned(WALK, ANN, 1, Why.RELEASED),
            NotReturned(DRIVE, ANN, 2, Why.RELEASED),
        ]
        assert model.loans.lenders(LEGS) == ()
        # The loan ends all the same.
        assert model.advance(1 + LOAN) == [
            Lost(WALK, BOB, 3, Why.DUE, on_loan=True),
            Lost(DRIVE, BOB, 4, Why.DUE, on_loan=True),
        ]

    def test_it_is_lent_on_and_comes_back_step_by_step(self, model: LeaseModel) -> None:
        model.borrow(WALK, BOB, 1)
        model.borrow(WALK, EVE, 2)
        assert [each.holder for each in model.loans.lenders(LEGS)] == [ANN, BOB]
        model.release(WALK, EVE, 3)
        assert holders(model) == {WALK: BOB, DRIVE: BOB}
        model.release(WALK, BOB, 3)
        assert holders(model) == {WALK: ANN, DRIVE: ANN}

    def test_a_loan_that_is_over_meanwhile_is_passed_over(self, model: LeaseModel) -> None:
        model.borrow(WALK, BOB, 1, 5)
        model.borrow(WALK, EVE, 2, 60)
        assert model.advance(6)[:2] == [NotReturned(WALK, BOB, 3, Why.DUE), NotReturned(DRIVE, BOB, 4, Why.DUE)]
        assert holders(model) == {WALK: EVE, DRIVE: EVE}
        model.release(WALK, EVE, 7)
        assert holders(model) == {WALK: ANN, DRIVE: ANN}

    def test_for_one_sentence(self, model: LeaseModel) -> None:
        model.borrow(WALK, BOB, 1, for_one=True)
        assert model.note_ended(WALK, ANN, 2) == []
        assert model.note_ended(WALK, BOB, 2) != []
        assert holders(model) == {WALK: ANN, DRIVE: ANN}
        assert model.note_ended(WALK, ANN, 3) == []

    def test_the_borrower_answers_and_hands_on_what_is_left_of_its_time(self, model: LeaseModel) -> None:
        model.borrow(WALK, BOB, 1, 5)
        request = asked(model.request(WALK, EVE, 2))
        model.grant(request.request_id, BOB, 3)
        assert holders(model) == {WALK: EVE, DRIVE: EVE}
        model.advance(6)
        assert holders(model) == {WALK: ANN, DRIVE: ANN}

    def test_a_lender_may_ask_for_it(self, model: LeaseModel) -> None:
        model.borrow(WALK, BOB, 1, 5)
        request = asked(model.request(WALK, ANN, 2))
        model.grant(request.request_id, BOB, 3)
        assert (holders(model), model.loans.count()) == ({WALK: ANN, DRIVE: ANN}, 0)

    def test_an_administrator_takes_it_from_lenders_too(self, model: LeaseModel) -> None:
        model.borrow(WALK, BOB, 1)
        assert model.take(WALK, EVE, 2)[-2:] == [
            NotReturned(WALK, ANN, 1, Why.TAKEN),
            NotReturned(DRIVE, ANN, 2, Why.TAKEN),
        ]
        model.release(WALK, EVE, 3)
        assert holders(model) == {}

    def test_what_is_free_is_held_and_not_lent(self, model: LeaseModel) -> None:
        model.leave(ANN, 1)
        model.borrow(WALK, BOB, 2)
        assert (holders(model), model.next_due()) == ({WALK: BOB, DRIVE: BOB}, None)
        model.borrow(WALK, BOB, 3)
        assert model.next_due() is None

    def test_those_in_line_wait_for_the_lender(self, model: LeaseModel) -> None:
        model.borrow(WALK, BOB, 1)
        model.request(WALK, EVE, 2)
        assert [change.holder for change in model.release(WALK, BOB, 3) if isinstance(change, Asked)] == [ANN]

    def test_a_lender_may_have_it_back_past_another_one(self, model: LeaseModel) -> None:
        model.borrow(WALK, BOB, 1)
        model.borrow(WALK, EVE, 2)
        request = asked(model.request(WALK, ANN, 3))
        assert NotReturned(WALK, BOB, 3, Why.GRANTED) in model.grant(request.request_id, EVE, 4)
        assert (holders(model), model.loans.count()) == ({WALK: ANN, DRIVE: ANN}, 0)

    def test_what_has_gone_does_not_come_back(self, model: LeaseModel) -> None:
        model.borrow(WALK, BOB, 1)
        assert model.end_all({LAMP}, 2) == []
        changes = model.end_all({DRIVE}, 2)
        assert NotReturned(DRIVE, ANN, 2, Why.GONE) in changes
        assert Lost(DRIVE, BOB, 4, Why.GONE, on_loan=True) in changes
        model.release(WALK, BOB, 3)
        assert holders(model) == {WALK: ANN}
        model.borrow(WALK, BOB, 4)
        # Without what it has named the lender has nothing back.
        assert NotReturned(WALK, ANN, 5, Why.GONE) in model.end_all({WALK}, 5)
        assert (holders(model), model.loans.lenders(LEGS)) == ({}, ())

    def test_what_is_lent_is_its_lenders_in_its_own_right(self, model: LeaseModel) -> None:
        model.borrow(WALK, BOB, 1)
        model.holding.bind(LAMP, BOB)
        assert (model.owned_by(ANN), model.owned_by(BOB)) == ({WALK: 1, DRIVE: 2}, {LAMP: 5})
        model.borrow(WALK, EVE, 2)
        assert (model.owned_by(BOB), model.owned_by(EVE)) == ({LAMP: 5}, {})


class TestNoEpochLeft:
    """A lender for which there is no epoch has nothing back, and the part is free: nothing of it is held by half."""

    def test_it_is_said(self) -> None:
        epochs = ClaimedEpochs(lambda: "the store is away")
        epochs.grant("r", 1, 4)
        model = LeaseModel(Rules(), epochs, parts=BodyParts())
        model.request(WALK, ANN, 0)
        model.borrow(WALK, BOB, 1)
        assert NotReturned(WALK, ANN, 1, Why.DUE) in model.release(WALK, BOB, 2)
        assert (holders(model), model.loans.count()) == ({}, 0)


def test_a_part_is_reserved_for_one_holder() -> None:
    model = LeaseModel(Rules(10, 30), parts=BodyParts())
    assert model.reserve(WALK, ANN, "ann", 0) == [Queued(WALK)]
    assert model.reserve(DRIVE, ANN, "ann", 0) == [Queued(DRIVE)]
    assert model.reserve(DRIVE, BOB, "bob", 0) == []
    assert (holders(model), model.may_go_on(ANN), model.may_go_on(BOB)) == ({WALK: ANN, DRIVE: ANN}, True, False)
    model.advance(10)
    assert holders(model) == {}
