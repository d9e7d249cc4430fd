"""The latch of STOP: by whom an engine is stopped, over gateways that come and go; beside the simplest reference."""

import pytest
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, rule, run_state_machine_as_test

from openrois.commands.stop_latch import MAX_AWAY, StopLatch

ENGINES = ("robot", "rover")


def stopped() -> StopLatch:
    latch = StopLatch()
    latch.latch("robot", "ann")
    return latch


def test_it_holds_until_it_is_released() -> None:
    latch = stopped()
    assert (latch.by("robot"), latch.by("rover"), len(latch)) == ("ann", "", 1)
    latch.latch("robot", "bob")
    assert latch.of(ENGINES) == {"robot": "bob"}
    assert latch.of(("rover",)) == {}
    assert latch.release("robot") == "bob"
    assert latch.release("robot") == ""
    assert (latch.by("robot"), len(latch)) == ("", 0)


@pytest.mark.parametrize(
    ("told", "instance", "by", "must_be_told"),
    [
        ("ann", "i", "ann", False),
        ("bob", "i", "bob", False),
        ("bob", "j", "bob", False),
        ("", "i", "", False),
        ("", "j", "ann", True),
        ("", "", "ann", True),
        (None, "i", "ann", False),
        (None, "", "ann", False),
    ],
    ids=["as it was", "by another", "of another", "handed back", "restarted", "nameless", "keeps none", "base wire"],
)
def test_an_adapter_that_comes_back(told: str | None, instance: str, by: str, must_be_told: bool) -> None:
    latch = stopped()
    latch.detach("robot", "i")
    assert latch.by("robot") == "ann"
    assert latch.attach("robot", told, instance) is must_be_told
    assert latch.by("robot") == by


def test_an_adapter_that_is_new_here_is_believed() -> None:
    latch = StopLatch()
    assert not latch.attach("robot", "ann", "i")
    assert not latch.attach("rover", "", "i")
    assert latch.of(ENGINES) == {"robot": "ann"}


def test_a_stop_while_the_adapter_is_away_is_not_taken_back_by_it() -> None:
    latch = stopped()
    latch.detach("robot", "i")
    latch.latch("robot", "bob")
    assert latch.attach("robot", "", "i")
    assert latch.by("robot") == "bob"


def test_of_too_many_that_are_away_the_first_is_forgotten() -> None:
    latch = StopLatch()
    for number in range(MAX_AWAY + 1):
        latch.latch(f"robot{number}", "ann")
        latch.detach(f"robot{number}")
    assert len(latch) == MAX_AWAY
    assert (latch.by("robot0"), latch.by("robot1")) == ("", "ann")
    # What is not stopped needs no place.
    latch.detach("rover")
    assert len(latch) == MAX_AWAY


@pytest.mark.parametrize(
    ("stop_id", "named", "may_be"),
    [("1", "1", True), ("1", "2", False), ("1", "", True), ("", "2", True), ("", "", True)],
)
def test_which_stop_may_be_the_one_of_an_id(stop_id: str, named: str, may_be: bool) -> None:
    latch = StopLatch()
    latch.latch("robot", "ann", stop_id)
    assert (latch.stop_id("robot"), latch.may_be("robot", named)) == (stop_id, may_be)
    # What is not stopped has no id.
    latch.release("robot")
    assert (latch.stop_id("robot"), latch.may_be("robot", named)) == ("", True)


def test_the_id_of_a_stop_comes_back_with_the_adapter() -> None:
    latch = stopped()
    latch.detach("robot", "i")
    latch.attach("robot", "bob", "i", "7")
    assert (latch.by("robot"), latch.stop_id("robot")) == ("bob", "7")


class Latches(RuleBasedStateMachine):
    """Two gateways, and one adapter that keeps the latch, is restarted, and is at one gateway at a time or at none.

    A person stops and hands back at any gateway that has the adapter. The reference is one name.
    """

    def __init__(self) -> None:
        super().__init__()
        self.gateways = {"a": StopLatch(), "b": StopLatch()}
        self.adapter = StopLatch()
        self.instance = 0
        self.at = ""
        self.by = ""

    @rule(gateway=st.sampled_from(("a", "b")))
    def attach(self, gateway: str) -> None:
        if self.at:
            return
        self.at = gateway
        latch = self.gateways[gateway]
        if latch.attach("robot", self.adapter.by("robot"), f"{self.instance}"):
            self.adapter.latch("robot", latch.by("robot"))
        if self.instance == 0:
            # It has not been restarted: whichever gateway it comes to knows by whom it was stopped.
            assert latch.by("robot") == self.by
        self.by = latch.by("robot")

    @rule()
    def detach(self) -> None:
        if self.at:
            self.gateways[self.at].detach("robot", f"{self.instance}")
            self.at = ""

    @rule()
    def restart_adapter(self) -> None:
        self.detach()
        self.adapter = StopLatch()
        self.instance += 1

    @rule(gateway=st.sampled_from(("a", "b")))
    def restart_gateway(self, gateway: str) -> None:
        if self.at == gateway:
            self.detach()
        self.gateways[gateway] = StopLatch()

    @rule(person=st.sampled_from(("ann", "bob")))
    def stop(self, person: str) -> None:
        if self.at:
            self.gateways[self.at].latch("robot", person)
            self.adapter.latch("robot", person)
            self.by = person

    @rule()
    def hand_back(self) -> None:
        if self.at:
            assert self.gateways[self.at].release("robot") == self.by
            self.adapter.release("robot")
            self.by = ""

    @invariant()
    def gateway_and_adapter_agree(self) -> None:
        if self.at:
            assert self.gateways[self.at].by("robot") == self.adapter.by("robot") == self.by


def test_gateway_and_adapter_agree_whatever_is_restarted() -> None:
    run_state_machine_as_test(Latches, settings=settings(max_examples=300, stateful_step_count=40, deadline=None))
