"""Nothing is used for a purpose that its visitor does not consent to at that moment, and has not since its capture."""

from collections.abc import Set as AbstractSet

import pytest
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, rule
from openrois_media.visitors.consent import Consent

from openrois.types.codes import Purpose

LIVE, RECOGNITION, AGENT = frozenset({Purpose.LIVE}), frozenset({Purpose.RECOGNITION}), frozenset({Purpose.AGENT})
SOME = st.frozensets(st.sampled_from(Purpose))


def test_before_any_statement_nothing_is_admitted() -> None:
    consent = Consent()
    assert not any(consent.admits({purpose}, 5.0) or consent.holds({purpose}) for purpose in Purpose)


def test_the_first_statement_holds_for_all_media_and_a_later_one_from_then_on() -> None:
    consent = Consent()
    assert consent.state(LIVE, 10.0) == set()
    assert consent.admits(LIVE, 3.0)
    assert consent.state(LIVE | AGENT, 20.0) == set()
    assert (consent.admits(AGENT, 19.9), consent.admits(AGENT, 20.0), consent.admits(LIVE, 3.0)) == (False, True, True)


def test_what_was_captured_before_a_withdrawal_is_not_admitted_after_a_new_consent() -> None:
    consent = Consent()
    consent.state(LIVE | RECOGNITION, 0.0)
    assert consent.state(LIVE, 1.0) == RECOGNITION
    assert not consent.admits(RECOGNITION, 0.5)
    consent.state(LIVE | RECOGNITION, 2.0)
    assert (consent.admits(RECOGNITION, 1.9), consent.admits(RECOGNITION, 2.0)) == (False, True)
    assert consent.admits(LIVE, 0.5)


def test_for_no_purpose_nothing_is_admitted() -> None:
    consent = Consent()
    consent.state(tuple(Purpose), 0.0)
    assert not consent.admits(frozenset(), 1.0)
    assert not consent.holds(frozenset())


@pytest.mark.parametrize("purposes", [LIVE | AGENT, {Purpose.RECORDING}])
def test_all_purposes_have_to_be_consented_to(purposes: AbstractSet[Purpose]) -> None:
    consent = Consent()
    consent.state(LIVE, 0.0)
    assert not consent.admits(purposes, 1.0)


class Deliveries(RuleBasedStateMachine):
    """Statements, captures and deliveries in any order, beside a record of all moments."""

    def __init__(self) -> None:
        super().__init__()
        self.consent = Consent()
        self.moments: list[list[frozenset[Purpose]]] = [[frozenset()]]
        """What was consented to, one statement after the other, in each second."""
        self.is_first = True

    @property
    def now(self) -> float:
        return float(len(self.moments) - 1)

    @property
    def stated(self) -> frozenset[Purpose]:
        return self.moments[-1][-1]

    @rule(purposes=SOME)
    def state(self, purposes: frozenset[Purpose]) -> None:
        assert self.consent.state(purposes, self.now) == self.stated - purposes
        if self.is_first:
            # It holds for whatever was captured before.
            self.moments = [[purposes] for _ in self.moments]
        self.moments[-1].append(purposes)
        self.is_first = False

    @rule()
    def wait(self) -> None:
        self.moments.append([self.stated])

    @rule(purposes=SOME, ago=st.integers(0, 20))
    def deliver(self, purposes: frozenset[Purpose], ago: int) -> None:
        captured = max(0, len(self.moments) - 1 - ago)
        first, *later = self.moments[captured:]
        held = [first[-1], *(each for moment in later for each in moment)]
        expected = bool(purposes) and all(purposes <= each for each in held)
        assert self.consent.admits(purposes, float(captured)) == expected

    @invariant()
    def what_holds_was_stated(self) -> None:
        assert self.consent.purposes == self.stated
        assert all(self.consent.holds({each}) == (each in self.stated) for each in Purpose)


TestDeliveries = Deliveries.TestCase
