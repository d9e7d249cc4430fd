"""Delays between attempts."""

import pytest

from openrois.transport.backoff import Backoff, asked_to_wait


def test_delays_grow_to_a_limit_and_start_over_after_something_that_lasted() -> None:
    backoff = Backoff()
    delays = [backoff.after(9.9) for _ in range(11)]
    assert delays[:4] == pytest.approx([1, 1.5, 2.25, 3.375])
    assert delays[-2:] == [30, 30]
    assert [backoff.after(10), backoff.after(0)] == [1, 1.5]


def test_its_numbers_can_be_chosen() -> None:
    backoff = Backoff(first=2, factor=3, limit=5, lasting=1)
    assert [backoff.after(lasted) for lasted in (0, 0, 0, 1)] == [2, 5, 5, 2]


@pytest.mark.parametrize(
    ("reason", "seconds"),
    [
        *(("retry_after=7", 7.0), ("retry_after=0.25", 0.25), ("retry_after=2.00 the store is\naway", 2.0)),
        *(("retry_after=99999", 0.0), ("retry_after=2s", 0.0), ("going away", 0.0), ("", 0.0)),
    ],
)
def test_a_gateway_that_restarts_may_say_when_to_come_back(reason: str, seconds: float) -> None:
    assert asked_to_wait(reason) == seconds
