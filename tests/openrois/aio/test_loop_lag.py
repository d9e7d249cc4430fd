"""How late the loop is, on a clock that the test turns."""

import asyncio

import pytest

from openrois.aio.loop_lag import PERIOD, LoopLag
from tests.support.clock import Clock


async def test_it_is_late_by_what_sleeping_took_too_long() -> None:
    clock = Clock(100.0)
    late = iter((0.0, 0.5, 0.25, -0.1))

    async def sleep(seconds: float) -> None:
        assert seconds == PERIOD
        try:
            clock.now += seconds + next(late)
        except StopIteration:
            raise asyncio.CancelledError from None

    lag = LoopLag(clock, sleep)
    with pytest.raises(asyncio.CancelledError):
        await lag.watch()
    assert (lag.last, lag.total, lag.turns) == (0.0, pytest.approx(0.75), 4)
    # However many read it, each reads the same.
    assert lag.most == lag.most == pytest.approx(0.5)


async def test_the_most_is_that_of_the_last_minute() -> None:
    clock = Clock(100.0)
    late = iter((9.0, *[0.125] * 239, 0.0))
    lag, most = LoopLag(clock, lambda seconds: sleep(seconds)), []

    async def sleep(seconds: float) -> None:
        most.append(lag.most)
        try:
            clock.now += seconds + next(late)
        except StopIteration:
            raise asyncio.CancelledError from None

    with pytest.raises(asyncio.CancelledError):
        await lag.watch()
    assert most == [0.0, *[9.0] * 240, 0.125]
