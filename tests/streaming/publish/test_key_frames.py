from itertools import pairwise

from hypothesis import given, settings
from hypothesis import strategies as st
from openrois_streaming.publish.key_frames import (
    REPAIR_INTERVAL,
    START_INTERVAL,
    STILL_SPACING,
    KeyFrameBudget,
    KeyFrameCause,
)
from openrois_streaming.publish.rendition_feed import STILL_INTERVAL, STILL_LEAST

START, REPAIR = KeyFrameCause.START, KeyFrameCause.REPAIR


def test_no_key_frame_without_a_request() -> None:
    assert KeyFrameBudget().take_cause(1.0) is None


def test_budget_is_asked_until_the_cause_is_taken() -> None:
    budget = KeyFrameBudget()
    asked = [budget.is_asked]
    budget.request(START)
    asked.append(budget.is_asked)
    budget.take_cause(1.0)
    assert [*asked, budget.is_asked] == [False, True, False]


def test_a_start_is_served_by_the_next_frame_and_once() -> None:
    budget = KeyFrameBudget()
    budget.request(START)
    assert budget.take_cause(1.0) is START
    assert budget.take_cause(2.0) is None


def test_waiting_starters_share_one_key_frame() -> None:
    budget = KeyFrameBudget()
    budget.request(START)
    assert budget.take_cause(1.0) is START
    for _ in range(5):
        budget.request(START)
    assert budget.take_cause(1.033) is None
    assert budget.take_cause(1.066) is None
    assert budget.take_cause(1.1) is START
    assert budget.take_cause(1.3) is None


def test_unserved_requests_pass_to_the_next_encoder() -> None:
    budget = KeyFrameBudget()
    budget.request(START)
    assert budget.take_cause(1.0) is START
    assert not budget.is_asked
    budget.restart()
    assert budget.is_asked
    assert budget.take_cause(1.2) is START
    budget.served()
    budget.restart()
    assert not budget.is_asked


def test_repairs_come_once_a_second() -> None:
    budget = KeyFrameBudget()
    made = []
    for tick in range(50):
        budget.request(REPAIR)
        if budget.take_cause(tick / 10):
            made.append(tick)
    assert made == [0, 10, 20, 30, 40]


def test_a_repair_does_not_delay_a_start() -> None:
    budget = KeyFrameBudget()
    budget.request(REPAIR)
    assert budget.take_cause(1.0) is REPAIR
    budget.request(START)
    assert budget.take_cause(1.01) is START


def test_a_start_does_not_use_up_the_repairs() -> None:
    budget = KeyFrameBudget()
    budget.request(START)
    assert budget.take_cause(1.0) is START
    budget.request(REPAIR)
    assert budget.take_cause(1.01) is REPAIR


def test_one_key_frame_serves_start_and_repair() -> None:
    budget = KeyFrameBudget()
    budget.request(REPAIR)
    budget.request(START)
    assert budget.take_cause(1.0) is START
    assert budget.take_cause(5.0) is None


def test_a_repair_serves_a_start_that_must_wait() -> None:
    budget = KeyFrameBudget()
    budget.request(START)
    assert budget.take_cause(1.0) is START
    budget.request(START)
    budget.request(REPAIR)
    assert budget.take_cause(1.05) is REPAIR
    assert budget.take_cause(5.0) is None


def test_single_pictures_wait_for_no_repair_and_not_for_each_other() -> None:
    assert STILL_SPACING <= STILL_INTERVAL - STILL_LEAST
    budget = KeyFrameBudget()
    budget.request(REPAIR)
    assert budget.take_cause(1.0) is REPAIR
    budget.request(KeyFrameCause.STILL)
    assert budget.take_cause(1.05) is KeyFrameCause.STILL
    budget.request(KeyFrameCause.STILL)
    assert budget.take_cause(1.05 + 0.9 * STILL_SPACING) is None
    assert budget.take_cause(1.06 + STILL_SPACING) is KeyFrameCause.STILL


def test_a_key_frame_that_comes_by_itself_serves_all() -> None:
    budget = KeyFrameBudget()
    budget.request(START)
    budget.request(REPAIR)
    budget.served()
    assert budget.take_cause(1.0) is None


_events = st.lists(st.tuples(st.integers(0, 400), st.sampled_from(["start", "repair", "frame", "frame"])), max_size=80)


@settings(max_examples=150, deadline=None)
@given(_events)
def test_the_budgets_hold_and_no_start_waits_for_repairs(events: list[tuple[int, str]]) -> None:
    budget = KeyFrameBudget()
    now_ms = 0
    made: dict[KeyFrameCause, list[float]] = {START: [], REPAIR: []}
    start_waits = repair_waits = False
    for wait_ms, what in events:
        now_ms += wait_ms
        now = now_ms / 1000
        if what != "frame":
            budget.request(KeyFrameCause(what))
            start_waits |= what == "start"
            repair_waits |= what == "repair"
            continue
        start_due = start_waits and (not made[START] or now - made[START][-1] >= START_INTERVAL)
        repair_due = repair_waits and (not made[REPAIR] or now - made[REPAIR][-1] >= REPAIR_INTERVAL)
        cause = budget.take_cause(now)
        assert cause is (START if start_due else REPAIR if repair_due else None)
        if cause:
            made[cause].append(now)
            start_waits = repair_waits = False
    assert all(later - earlier >= START_INTERVAL for earlier, later in pairwise(made[START]))
    assert all(later - earlier >= REPAIR_INTERVAL for earlier, later in pairwise(made[REPAIR]))
