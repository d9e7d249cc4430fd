"""Virtual time: it jumps to the next timer, in order, and no clock of the machine has a part in it."""

import asyncio
from collections.abc import Coroutine
from typing import Any

import pytest
from openrois_bench.simulation.clock import VirtualClock, install
from openrois_bench.simulation.loop import NothingLeft, VirtualLoop
from openrois_bench.simulation.meter import Meter

HALF_A_DAY = 12 * 3600.0


def run(work: Coroutine[Any, Any, None]) -> VirtualClock:
    clock = VirtualClock()
    with asyncio.Runner(loop_factory=lambda: VirtualLoop(clock, Meter())) as runner:
        runner.run(work)
    return clock


def test_a_timer_of_twelve_hours_fires_behind_all_that_are_shorter() -> None:
    fired: list[tuple[str, float]] = []

    async def wait() -> None:
        loop = asyncio.get_running_loop()
        began = loop.time()

        async def note(name: str, seconds: float) -> None:
            await asyncio.sleep(seconds)
            fired.append((name, loop.time() - began))

        times = {"half a day": HALF_A_DAY, "a second": 1.0, "an hour": 3600.0, "at once": 0.0, "also a second": 1.0}
        await asyncio.gather(*(note(name, seconds) for name, seconds in times.items()))

    clock = run(wait())
    assert [name for name, _ in fired] == ["at once", "a second", "also a second", "an hour", "half a day"]
    assert [when for _, when in fired] == pytest.approx([0.0, 1.0, 1.0, 3600.0, HALF_A_DAY])
    assert clock.monotonic() - VirtualClock().monotonic() == pytest.approx(HALF_A_DAY)
    assert clock.wall() - VirtualClock().wall() == pytest.approx(HALF_A_DAY)


def test_a_timeout_is_over_in_virtual_time() -> None:
    async def wait() -> None:
        with pytest.raises(TimeoutError):
            async with asyncio.timeout(HALF_A_DAY):
                await asyncio.Event().wait()

    run(wait())


def test_a_cancelled_timer_does_not_let_time_pass() -> None:
    async def wait() -> None:
        asyncio.get_running_loop().call_later(HALF_A_DAY, print).cancel()
        await asyncio.sleep(1)

    clock = run(wait())
    assert clock.now - VirtualClock().now == pytest.approx(1)


def test_many_cancelled_timers_do_not_stay() -> None:
    async def wait() -> None:
        loop = asyncio.get_running_loop()
        for _ in range(1000):
            loop.call_later(HALF_A_DAY, print).cancel()
        kept = loop.call_later(2 * HALF_A_DAY, print)
        await asyncio.sleep(0)
        await asyncio.sleep(1)
        assert len(loop._scheduled) == 1  # type: ignore[attr-defined]
        kept.cancel()

    run(wait())


def test_a_callback_that_fails_is_reported_and_does_not_stop_the_loop() -> None:
    async def wait() -> None:
        loop = asyncio.get_running_loop()
        failed: list[str] = []
        loop.set_exception_handler(lambda _loop, context: failed.append(repr(context["exception"])))
        loop.call_soon(lambda: [][0])
        await asyncio.sleep(1)
        assert failed == ["IndexError('list index out of range')"]

    run(wait())


def test_tasks_that_wait_for_each_other_are_an_error() -> None:
    async def wait() -> None:
        await asyncio.Event().wait()

    with pytest.raises(NothingLeft, match="no timer is left"):
        run(wait())


def test_clocks_are_not_replaced_under_a_gateway_that_has_read_them() -> None:
    import openrois

    assert openrois
    with pytest.raises(RuntimeError, match="start a process of its own"):
        install(VirtualClock())
