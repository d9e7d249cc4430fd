"""Gives memory that a burst has left behind back to the system, once the process is at rest."""

import asyncio
import ctypes
import logging
import mmap
import time
from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import Final

__all__ = ["MemoryReturn", "returning_memory", "trim_memory"]

_log = logging.getLogger(__name__)

PERIOD: Final = 5.0
"""Seconds between two measurements."""

AT_REST: Final = 0.2
"""Share of a processor below which a process is at rest: whatever allocates waits while memory is given back."""

WORTHWHILE: Final = 32 * 1024 * 1024
"""Bytes above the least that it ever had, which a process keeps; it is also what makes giving back a success."""

LEAST_INTERVAL: Final = 60.0
"""Seconds between two times: each takes some milliseconds, in which STOP waits too."""

LONGEST_INTERVAL: Final = 960.0
"""Seconds between two times where little came of it: what the process has is in use. Each failure doubles them."""


class MemoryReturn:
    """Decides when memory is given back.

    What lies unused in the heap is not asked for: to count it takes the C library as long as to give it back.

    Args:
        now: monotonic seconds.
        cpu: processor seconds that the process has used.
        resident: bytes that it has in memory.
    """

    def __init__(self, now: float, cpu: float, resident: int) -> None:
        self._now = now
        self._cpu = cpu
        self._least = resident
        self._interval = LEAST_INTERVAL
        self._not_before = now

    def is_due(self, now: float, cpu: float, resident: int) -> bool:
        """Tell whether memory is to be given back now: the process has grown, and was at rest since the last look."""
        was_at_rest = cpu - self._cpu < AT_REST * (now - self._now)
        self._now, self._cpu = now, cpu
        self._least = min(self._least, resident)
        return was_at_rest and resident - self._least >= WORTHWHILE and now >= self._not_before

    def note_trimmed(self, now: float, returned: int) -> None:
        """Wait before the next time, longer each time if fewer bytes were returned than was worth the while."""
        failed = returned < WORTHWHILE
        self._interval = min(2 * self._interval, LONGEST_INTERVAL) if failed else LEAST_INTERVAL
        self._not_before = now + self._interval


def resident_memory() -> int:
    """Return the bytes that this process has in memory, as Linux tells them."""
    return int(Path("/proc/self/statm").read_text().split()[1]) * mmap.PAGESIZE


def trim_memory() -> None:
    """Have glibc give back every page in which nothing is in use; it keeps those between others by itself."""
    ctypes.CDLL(None).malloc_trim(0)


def can_trim() -> bool:
    """Tell whether the C library is glibc on Linux: others give memory back by themselves, or cannot."""
    return Path("/proc/self/statm").exists() and hasattr(ctypes.CDLL(None), "malloc_trim")


async def returning_memory(
    clock: Callable[[], float] = time.monotonic, sleep: Callable[[float], Awaitable[None]] = asyncio.sleep
) -> None:
    """Measure for ever, and give memory back when that is due.

    Args:
        clock: monotonic seconds.
        sleep: waits for some seconds.
    """
    if not can_trim():
        return
    decision = MemoryReturn(clock(), time.process_time(), resident_memory())
    while True:
        await sleep(PERIOD)
        before = resident_memory()
        if not decision.is_due(clock(), time.process_time(), before):
            continue
        # In a thread: whatever needs no memory from the C library goes on meanwhile.
        await asyncio.to_thread(trim_memory)
        after = resident_memory()
        decision.note_trimmed(clock(), before - after)
        _log.info("gave %d MiB of memory back to the system, %d MiB are left", (before - after) >> 20, after >> 20)
