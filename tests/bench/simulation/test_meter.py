"""What callbacks are charged to, with a clock that is set by hand."""

import asyncio
import gc
from collections.abc import Callable, Iterator
from typing import Any

import pytest
from openrois_bench.simulation.meter import Account, Meter, charged


class Hands:
    """A clock that the callbacks of a test move on."""

    def __init__(self) -> None:
        self.ticks = 0
        self.cpu = 0.0

    def work(self, ticks: int) -> None:
        self.ticks += ticks


@pytest.fixture
def handle() -> Iterator[Callable[..., asyncio.Handle]]:
    """Return a function that makes the handle of a callback in the context of the caller."""
    loop = asyncio.new_event_loop()
    loop.set_exception_handler(lambda _loop, _context: None)

    def make(callback: Callable[..., object], *arguments: Any) -> asyncio.Handle:
        return asyncio.Handle(callback, arguments, loop)

    yield make
    loop.close()


@pytest.fixture
def account() -> Iterator[Account]:
    """Return the account that callbacks of a test are charged to unless it says otherwise."""
    token = charged.set(own := Account("peers"))
    yield own
    charged.reset(token)


@pytest.mark.usefixtures("account")
def test_a_callback_is_charged_to_the_account_of_its_context(handle: Callable[..., asyncio.Handle]) -> None:
    hands, one = Hands(), Account("one")
    meter = Meter(lambda: hands.ticks, lambda: hands.cpu)
    before = meter.read()
    token = charged.set(one)
    meter.run(handle(hands.work, 600))
    charged.reset(token)
    meter.run(handle(hands.work, 200))
    # What the loop takes between callbacks.
    hands.work(200)
    hands.cpu = 0.5
    spent = meter.read().seconds_since(before)
    # Half of a thousand ticks were another process's.
    assert {account.name: seconds for account, seconds in spent.items()} == pytest.approx(
        {"one": 0.5 * 0.6, "peers": 0.5 * 0.2}
    )


@pytest.mark.usefixtures("account")
def test_a_callback_that_fails_is_charged(handle: Callable[..., asyncio.Handle]) -> None:
    hands = Hands()
    meter = Meter(lambda: hands.ticks, lambda: hands.cpu)

    def fail() -> None:
        hands.work(7)
        raise ValueError

    before = meter.read()
    meter.run(handle(fail))
    hands.cpu = 1.0
    assert sum(meter.read().seconds_since(before).values()) == pytest.approx(1.0)


@pytest.mark.usefixtures("account")
def test_the_collector_is_charged_to_no_account(handle: Callable[..., asyncio.Handle]) -> None:
    hands = Hands()
    meter = Meter(lambda: hands.ticks, lambda: hands.cpu)

    def collect() -> None:
        hands.work(10)
        for phase in ("start", "stop"):
            gc.callbacks[-1](phase, {})
            hands.work(90 if phase == "start" else 0)

    before = meter.read()
    with meter.watching_collector():
        meter.run(handle(collect))
    hands.cpu = 1.0
    assert sum(meter.read().seconds_since(before).values()) == pytest.approx(0.1)
    assert meter._collected not in gc.callbacks


@pytest.mark.usefixtures("account")
def test_nothing_was_spent_between_two_readings_at_once(handle: Callable[..., asyncio.Handle]) -> None:
    hands = Hands()
    meter = Meter(lambda: hands.ticks, lambda: hands.cpu)
    meter.run(handle(hands.work, 5))
    assert set(meter.read().seconds_since(meter.read()).values()) == {0.0}
