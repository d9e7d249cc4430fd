"""The rules of leases, each by itself."""

import pytest

from openrois.errors import OutOfResources, Unsupported
from openrois.leases.changes import Asked, Change, Declined, Gained, Lost, Queued, Why, Withdrawn
from openrois.leases.epochs import ClaimedEpochs
from openrois.leases.model import LeaseModel, Replayed, Rules
from openrois.leases.waiting import MAX_WAITING, Request

GRACE, PATIENCE = 10.0, 30.0
LAMP, ARM = "r/lamp", "r/arm"


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
