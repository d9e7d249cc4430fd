"""Holders of components."""

import pytest

from openrois.errors import OutOfResources
from openrois.leases.epochs import CountedEpochs
from openrois.leases.holding import Holding

LAMP, BELL = "r/lamp", "r/bell"


class Holder:
    """Two of them are equal and still two."""

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Holder)

    __hash__ = object.__hash__


@pytest.fixture
def ann() -> Holder:
    return Holder()


@pytest.fixture
def bob() -> Holder:
    return Holder()


def test_one_holder_at_a_time(ann: Holder, bob: Holder) -> None:
    held = Holding()
    held.bind(LAMP, ann)
    held.bind(LAMP, ann)
    held.bind(BELL, bob)
    with pytest.raises(OutOfResources):
        held.bind(LAMP, bob)
    assert (held.is_held(LAMP, ann), held.is_held(LAMP, bob), held.is_held("r/x", ann)) == (True, False, False)
    barred = held.is_held_by_another(LAMP, ann), held.is_held_by_another(LAMP, bob), held.is_held_by_another("r/x", ann)
    assert barred == (False, True, False)


def test_only_the_holder_releases(ann: Holder, bob: Holder) -> None:
    held = Holding()
    held.bind(LAMP, ann)
    held.release(LAMP, bob)
    assert held.is_held(LAMP, ann)
    held.release(LAMP, ann)
    held.release(LAMP, ann)
    held.bind(LAMP, bob)
    assert held.is_held(LAMP, bob)


def test_everything_of_one_holder(ann: Holder, bob: Holder) -> None:
    held = Holding()
    held.bind(LAMP, ann)
    held.bind(BELL, bob)
    assert (held.held_by(ann), held.held_by(bob), held.held()) == ({LAMP: 1}, {BELL: 2}, {LAMP, BELL})
    assert (held.holder(LAMP), held.holder("r/x")) == ((ann, 1), None)


def test_each_holder_has_an_epoch_of_its_own(ann: Holder, bob: Holder) -> None:
    held = Holding()
    assert (held.bind(LAMP, ann), held.bind(LAMP, ann), held.bind(BELL, ann)) == (1, 1, 2)
    assert (held.release(LAMP, bob), held.release(LAMP, ann), held.release(LAMP, ann)) == (None, 1, None)
    assert held.bind(LAMP, bob) == 3
    assert held.move(LAMP, ann) == 4
    assert held.is_held(LAMP, ann)


def test_a_successor_goes_on_in_the_same_epochs(ann: Holder, bob: Holder) -> None:
    held = Holding(CountedEpochs(7))
    held.bind(LAMP, ann)
    held.succeed(LAMP, bob)
    assert (held.held_by(bob), held.held_by(ann)) == ({LAMP: 7}, {})
