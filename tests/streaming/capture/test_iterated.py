"""Iterators that are read for a source, in the loop or in a thread."""

import asyncio
import itertools
import threading
from collections.abc import AsyncIterator, Iterator
from functools import partial

import pytest
from openrois_streaming.capture import iterated
from openrois_streaming.capture.iterated import Items, IteratedSource

from tests.support.streaming import VirtualClock


def source(items: Items[int], clock: VirtualClock | None = None, depth: int = 4) -> IteratedSource[int]:
    return IteratedSource(items, clock=clock or VirtualClock(), depth=depth, name="numbers")


class Counted:
    """A blocking iterator that gives a number whenever the test lets it, and tells in which thread it was closed."""

    def __init__(self) -> None:
        self.gates = threading.Semaphore(0)
        self.closed_in: list[threading.Thread] = []
        self.opened = 0

    def __call__(self) -> Iterator[int]:
        self.opened += 1
        try:
            number = 0
            while True:
                self.gates.acquire()
                yield number
                number += 1
        finally:
            self.closed_in.append(threading.current_thread())


async def test_a_blocking_iterator_is_read_and_closed_in_a_thread_of_its_own() -> None:
    counted, clock = Counted(), VirtualClock()
    numbers = source(counted, clock)
    # The read that is under way when the source is closed comes back while that is waited for.
    come_back = partial(asyncio.get_running_loop().call_soon, counted.gates.release)
    async with asyncio.timeout(10):
        async with numbers.open() as items:
            counted.gates.release()
            first = await anext(items)
            await clock.advance(1.5)
            counted.gates.release()
            second = await anext(items)
            come_back()
        assert (first.number, first.value, first.came_at) == (0, 0, 1000.0)
        assert (second.number, second.value, second.came_at) == (1, 1, 1001.5)
        (thread,) = counted.closed_in
        assert thread is not threading.main_thread()
        async with numbers.open() as items:
            counted.gates.release()
            third = await anext(items)
            come_back()
    assert (third.number, third.value) == (2, 0), "the numbers go on"
    assert counted.opened == 2


async def test_an_asynchronous_iterator_is_read_in_the_loop_and_closed() -> None:
    closed = []

    async def numbers() -> AsyncIterator[int]:
        try:
            for number in range(7, 10):
                yield number
        finally:
            closed.append(threading.current_thread())

    clock = VirtualClock()
    own = source(numbers, clock)
    async with own.open() as items:
        assert await anext(items) == (0, 7, 1000.0)
    assert closed == [threading.main_thread()]
    async with own.open() as items:
        assert [each.number async for each in items] == [1, 2, 3]


async def test_of_what_waits_for_a_busy_loop_the_oldest_is_lost() -> None:
    done = threading.Event()

    def numbers() -> Iterator[int]:
        yield from range(10)
        done.set()

    async with asyncio.timeout(10), source(numbers, depth=2).open() as items:
        done.wait(10)  # the event loop is busy until all are there
        assert [each.value async for each in items] == [8, 9]


async def endless() -> AsyncIterator[int]:
    while True:
        yield 1


@pytest.mark.parametrize("items", [endless, lambda: itertools.repeat(1)])
async def test_an_iterator_that_never_waits_leaves_the_event_loop_to_others(items: Items[int]) -> None:
    others: list[str] = []
    async with source(items).open() as numbers:
        await anext(numbers)
        asyncio.get_running_loop().call_soon(others.append, "ran")
        for _ in range(3):
            await anext(numbers)
    assert others


async def test_what_an_iterator_raises_comes_after_what_it_gave() -> None:
    def numbers() -> Iterator[int]:
        yield 1
        raise OSError("the cable is out")

    async with asyncio.timeout(10), source(numbers).open() as items:
        assert (await anext(items)).value == 1
        with pytest.raises(OSError, match="the cable is out"):
            await anext(items)


async def test_a_thread_that_does_not_come_back_is_not_waited_for_and_holds_its_device(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr(iterated, "CLOSE_TIMEOUT", 0.01)
    counted = Counted()
    numbers = source(counted)
    async with asyncio.timeout(10):
        async with numbers.open():
            pass
        assert "capture numbers does not come back from its last read" in caplog.text
        with pytest.raises(RuntimeError, match="has not come back from its last read, and is opened when it does: if"):
            async with numbers.open():
                pass
        counted.gates.release()
        await asyncio.to_thread(next(each for each in threading.enumerate() if each.name == "capture numbers").join)
        async with numbers.open() as items:
            counted.gates.release()
            assert (await anext(items)).value == 0
            asyncio.get_running_loop().call_soon(counted.gates.release)
    assert counted.opened == 2


def test_a_thread_that_comes_back_after_its_event_loop_is_no_hindrance(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(iterated, "CLOSE_TIMEOUT", 0.01)
    counted = Counted()
    numbers = source(counted)

    async def look() -> None:
        async with numbers.open():
            pass

    asyncio.run(look())
    counted.gates.release()
    next(each for each in threading.enumerate() if each.name == "capture numbers").join(10)
    counted.gates.release()
    asyncio.run(look())
    assert counted.opened == 2


async def test_a_device_that_cannot_be_released_is_told_of(caplog: pytest.LogCaptureFixture) -> None:
    def numbers() -> Iterator[int]:
        try:
            while True:
                yield 1
        finally:
            raise OSError("the port is gone")

    own = source(numbers)
    for _ in range(2):
        async with asyncio.timeout(10), own.open() as items:
            await anext(items)
    assert "capture numbers: the device may not be released: OSError('the port is gone')" in caplog.text


@pytest.mark.parametrize("wrong", [[1, 2], 7, None])
async def test_what_is_no_iterator_is_refused(wrong: object) -> None:
    with pytest.raises(TypeError, match=f"must be a function that returns an iterator, not a {type(wrong).__name__}"):
        async with source(lambda: wrong).open():  # type: ignore[arg-type, return-value]
            pass
