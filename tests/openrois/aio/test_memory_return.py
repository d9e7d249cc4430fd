"""When memory goes back to the system, and that it does: with the C library's real heap, in a process of its own."""

import json
import subprocess
import sys

import pytest

from openrois.aio.memory_return import (
    AT_REST,
    LEAST_INTERVAL,
    LONGEST_INTERVAL,
    PERIOD,
    WORTHWHILE,
    MemoryReturn,
    can_trim,
    returning_memory,
)

USED = 60 << 20
BUSY = PERIOD * AT_REST

BURSTS = """
import asyncio, json, time
from openrois.aio import memory_return

def resident():
    return memory_return.resident_memory() >> 20

def burst():
    # Of much that is allocated, here and there a little stays: what is free lies between what is in use.
    messages = [bytearray(6_000) for _ in range(20_000)]
    return messages[::200]

async def main():
    now, kept, measured = 0.0, [], []

    async def sleep(seconds):
        nonlocal now
        now += 60.0
        if len(measured) == 3 * 2:
            raise asyncio.CancelledError
        if len(measured) % 2:
            measured.append(resident())
        else:
            kept.append(burst())
            measured.append(resident())

    before = resident()
    try:
        await memory_return.returning_memory(lambda: now, sleep)
    except asyncio.CancelledError:
        print(json.dumps([before, *measured]))

asyncio.run(main())
"""


def test_it_is_due_when_the_process_has_grown_and_rests() -> None:
    decision = MemoryReturn(0.0, 0.0, USED)
    assert not decision.is_due(PERIOD, BUSY, USED + WORTHWHILE)
    assert not decision.is_due(2 * PERIOD, BUSY, USED + WORTHWHILE - 1)
    assert decision.is_due(3 * PERIOD, BUSY, USED + WORTHWHILE)


@pytest.mark.parametrize(("returned", "interval"), [(WORTHWHILE, LEAST_INTERVAL), (WORTHWHILE - 1, 2 * LEAST_INTERVAL)])
def test_it_is_due_once_a_minute_at_most_and_later_where_little_came_of_it(returned: int, interval: float) -> None:
    decision = MemoryReturn(0.0, 0.0, USED)
    decision.note_trimmed(10.0, returned)
    assert not decision.is_due(10.0 + interval - 1, 0.0, 3 * USED)
    assert decision.is_due(10.0 + interval, 0.0, 3 * USED)


def test_each_failure_doubles_the_interval_up_to_a_limit_and_a_success_ends_that() -> None:
    decision = MemoryReturn(0.0, 0.0, USED)
    for _ in range(10):
        decision.note_trimmed(0.0, 0)
    assert not decision.is_due(LONGEST_INTERVAL - 1, 0.0, 3 * USED)
    assert decision.is_due(LONGEST_INTERVAL, 0.0, 3 * USED)
    decision.note_trimmed(LONGEST_INTERVAL, USED)
    assert decision.is_due(LONGEST_INTERVAL + LEAST_INTERVAL, 0.0, 3 * USED)


def test_a_process_is_compared_with_the_least_that_it_ever_had() -> None:
    decision = MemoryReturn(0.0, 0.0, 3 * USED)
    assert not decision.is_due(PERIOD, 0.0, USED)
    assert decision.is_due(2 * PERIOD, 0.0, USED + WORTHWHILE)


@pytest.mark.skipif(not can_trim(), reason="only glibc on Linux keeps memory and can be told to give it back")
def test_memory_does_not_grow_from_burst_to_burst() -> None:
    done = subprocess.run([sys.executable, "-c", BURSTS], capture_output=True, text=True, check=True, timeout=60)
    before, _, first, _, second, _, third = json.loads(done.stdout)
    assert max(first, second, third) < before + 20, done.stdout
    assert third - first < 10, done.stdout


async def test_without_such_a_library_nothing_is_done(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("openrois.aio.memory_return.can_trim", lambda: False)
    await returning_memory()
