"""An asyncio event loop in virtual time: where nothing is ready, the time jumps to the next timer."""

import asyncio
from collections import deque
from heapq import heapify, heappop
from typing import Any, Final

from openrois_bench.simulation.clock import VirtualClock
from openrois_bench.simulation.meter import Meter

__all__ = ["NothingLeft", "VirtualLoop"]

_CANCELLED: Final = 100
"""Timers that were cancelled and may stay among the others."""


class NothingLeft(Exception):
    """Every task waits for another one, and no timer is left."""


class VirtualLoop(asyncio.BaseEventLoop):
    """An event loop without sockets.

    Args:
        clock: is advanced.
        meter: charges what runs.
    """

    # asyncio's own, which have no types.
    _scheduled: list[Any]
    _ready: deque[asyncio.Handle]
    _stopping: bool
    _timer_cancelled_count: int

    def __init__(self, clock: VirtualClock, meter: Meter) -> None:
        super().__init__()
        self._clock = clock
        self._meter = meter

    def time(self) -> float:
        """Return the virtual time."""
        return self._clock.now

    def _run_once(self) -> None:
        """Let time pass until something is ready, and run what is ready by then, each charged to its account.

        In the place of that of asyncio, for which each callback would have to be wrapped to be charged.
        """
        scheduled, ready = self._scheduled, self._ready
        if self._timer_cancelled_count > _CANCELLED and self._timer_cancelled_count * 2 > len(scheduled):
            for timer in scheduled:
                timer._scheduled = not timer._cancelled
            scheduled[:] = [timer for timer in scheduled if timer._scheduled]
            heapify(scheduled)
            self._timer_cancelled_count = 0
        while scheduled and scheduled[0]._cancelled:
            self._timer_cancelled_count -= 1
            heappop(scheduled)._scheduled = False
        if not ready and not self._stopping:
            if not scheduled:
                raise NothingLeft("every task waits, and no timer is left that could end that")
            self._clock.advance(max(scheduled[0]._when - self._clock.now, 0.0))
        while scheduled and scheduled[0]._when <= self._clock.now:
            timer = heappop(scheduled)
            timer._scheduled = False
            ready.append(timer)
        for _ in range(len(ready)):
            handle = ready.popleft()
            if not handle._cancelled:
                self._meter.run(handle)

    def _write_to_self(self) -> None:
        """Do nothing: no other thread has to wake this loop, which never waits."""
