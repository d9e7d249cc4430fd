import asyncio
import time

import pytest
from openrois_streaming.clock import SystemClock, wall_at

from tests.support.streaming import VirtualClock


async def test_the_system_clock_is_the_one_that_all_processes_of_the_machine_share() -> None:
    before = time.clock_gettime(time.CLOCK_MONOTONIC)
    now = SystemClock().now()
    assert before <= now <= time.clock_gettime(time.CLOCK_MONOTONIC)


async def test_a_sleeper_never_wakes_early_even_if_the_timer_does(monkeypatch: pytest.MonkeyPatch) -> None:
    clock = SystemClock()
    now = 50.0
    slept = []

    async def early_timer(seconds: float) -> None:
        nonlocal now
        slept.append(seconds)
        now += max(seconds * 0.9, 0.001)

    monkeypatch.setattr(asyncio, "sleep", early_timer)
    monkeypatch.setattr(time, "monotonic", lambda: now)
    await clock.sleep_until(50.02)
    assert 50.02 <= now < 50.0225
    assert min(slept) == 0.001, "a shorter timer would keep an event loop busy"


async def test_a_moment_that_has_passed_is_not_waited_for() -> None:
    clock = SystemClock()
    async with asyncio.timeout(1):
        await clock.sleep_until(clock.now() - 1)


def test_the_time_of_day_of_a_moment() -> None:
    clock = VirtualClock(now=100.0, wall=5000.0)
    assert wall_at(clock, 98.5) == pytest.approx(4998.5)
    clock.step_wall(3600)
    assert wall_at(clock, 100.0) == pytest.approx(8600.0)


def test_system_clock_gives_the_time_of_day() -> None:
    assert abs(SystemClock().wall() - time.time()) < 1
