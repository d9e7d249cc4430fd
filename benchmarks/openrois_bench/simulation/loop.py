"""An asyncio event loop in virtual time: where nothing is ready, the time jumps to the next timer."""

import asyncio
from collections.abc import Callable
from contextvars import Context
from typing import TypeVarTuple, Unpack

from openrois_bench.simulation.clock import VirtualClock
from openrois_bench.simulation.meter import Meter

__all__ = ["NothingLeft", "VirtualLoop"]

Arguments = TypeVarTuple("Arguments")


class NothingLeft(Exception):
    """Every task waits for another one, and no timer is left."""


class _Jump:
    """Stands where a loop waits for sockets: there are none, so that it only lets time pass."""

    def __init__(self, clock: VirtualClock) -> None:
        self._clock = clock

    def select(self, timeout: float | None) -> tuple[()]:
        if timeout is None:
            raise NothingLeft("every task waits, and no timer is left that could end that")
        if timeout > 0:
            self._clock.advance(timeout)
        return ()


class VirtualLoop(asyncio.BaseEventLoop):
    """An event loop without sockets.

    Args:
        clock: is advanced.
        meter: charges what runs.
    """

    def __init__(self, clock: VirtualClock, meter: Meter) -> None:
        super().__init__()
        self._selector = _Jump(clock)
        self._clock = clock
        self._meter = meter

    def time(self) -> float:
        """Return the virtual time."""
        return self._clock.now

    def call_soon(
        self, callback: Callable[[Unpack[Arguments]], object], *args: *Arguments, context: Context | None = None
    ) -> asyncio.Handle:
        """Call in the next turn, and charge it."""
        return super().call_soon(self._meter.run, callback, args, context=context)

    def call_at(
        self,
        when: float,
        callback: Callable[[Unpack[Arguments]], object],
        *args: *Arguments,
        context: Context | None = None,
    ) -> asyncio.TimerHandle:
        """Call at a time, and charge it."""
        return super().call_at(when, self._meter.run, callback, args, context=context)

    def _process_events(self, _events: object) -> None:
        """Do nothing: there are no sockets."""

    def _write_to_self(self) -> None:
        """Do nothing: no other thread has to wake this loop, which never waits."""
