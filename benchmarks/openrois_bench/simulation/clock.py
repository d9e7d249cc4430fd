"""A clock that jumps, in the place of the clocks of this process."""

import sys
import time
from collections.abc import Callable
from typing import Final

__all__ = ["VirtualClock", "install"]

_BEGINNING: Final = 1000.0
"""Monotonic seconds at which virtual time begins."""

_EPOCH: Final = 1_800_000_000.0
"""Epoch seconds at that time: the same for each run."""


class VirtualClock:
    """Seconds that pass only when `advance` says so.

    Attributes:
        now: monotonic seconds.
    """

    def __init__(self) -> None:
        self.now = _BEGINNING

    def advance(self, seconds: float) -> None:
        """Let seconds pass."""
        self.now += seconds

    def monotonic(self) -> float:
        """Return monotonic seconds."""
        return self.now

    def wall(self) -> float:
        """Return epoch seconds."""
        return _EPOCH + self.now - _BEGINNING


def install(clock: VirtualClock) -> None:
    """Replace the clocks of this process, for as long as it runs.

    The gateway's modules keep the clock that they find when they are imported, so this comes before. Turns of the loop
    are timed by `perf_counter`: it is virtual too, so that each run reads messages in the same order.

    Raises:
        RuntimeError: a module of the gateway has been imported.
    """
    if any(name.partition(".")[0] == "openrois" for name in sys.modules):
        raise RuntimeError("the clock has to be installed before `openrois` is imported: start a process of its own")
    clocks: dict[str, Callable[[], float]] = {
        "monotonic": clock.monotonic,
        "perf_counter": clock.monotonic,
        "time": clock.wall,
    }
    for name, function in clocks.items():
        setattr(time, name, function)
