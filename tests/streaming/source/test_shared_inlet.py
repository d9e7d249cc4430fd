import asyncio
import logging
from collections.abc import AsyncGenerator, AsyncIterator
from contextlib import aclosing, asynccontextmanager

import pytest
from openrois_streaming.source.shared_inlet import SharedInlet

from tests.support.streaming import FedSource, settle


async def test_inlet_reads_the_plugged_in_sender() -> None:
    inlet: SharedInlet[int] = SharedInlet("microphone")
    first: FedSource[int] = FedSource()
    second: FedSource[int] = FedSource()
    async with inlet.subscribe(8) as reader:
        await settle()
        inlet.plug("a", first)
        assert inlet.stream_id == "a"
        await first.feed(1, 2)
        inlet.plug("b", second)
        await settle()
        assert (first.closed, second.opened) == (1, 1)
        await first.feed(3)
        await second.feed(4)
        inlet.unplug("a")
        assert inlet.stream_id == "b"
        inlet.unplug("b")
        await settle()
        assert (inlet.stream_id, second.closed) == (None, 1)
        inlet.plug("a", first)
        await settle()
        assert [await reader.get() for _ in range(4)] == [1, 2, 4, 3]
    assert first.opened == first.closed == 2


async def test_source_stays_closed_without_readers() -> None:
    inlet: SharedInlet[int] = SharedInlet("camera")
    source: FedSource[int] = FedSource()
    inlet.plug("a", source)
    await settle()
    assert source.opened == 0
    async with inlet.subscribe(), inlet.subscribe():
        await settle()
        assert source.opened == 1
    assert source.closed == 1


async def test_a_source_that_fails_or_ends_is_given_up_until_the_next(caplog: pytest.LogCaptureFixture) -> None:
    inlet: SharedInlet[int] = SharedInlet("camera")
    async with inlet.subscribe(8) as reader:
        refusing: FedSource[int] = FedSource()
        refusing.refusal = RuntimeError("it is open already")
        failing: FedSource[int] = FedSource()
        ending: FedSource[int] = FedSource()
        good: FedSource[int] = FedSource()
        with caplog.at_level(logging.WARNING):
            for source in (refusing, failing):
                inlet.plug("a", source)
                await settle()
                await source.end(ValueError("broken"))
        assert [record.message for record in caplog.records] == [
            "camera: the media of the sender cannot be read: RuntimeError('it is open already')",
            "camera: the media of the sender cannot be read: ValueError('broken')",
        ]
        inlet.plug("a", ending)
        await ending.feed(1)
        await ending.end()
        inlet.plug("a", good)
        await good.feed(2)
        assert [await reader.get() for _ in range(2)] == [1, 2]
    assert good.opened == good.closed == failing.closed == ending.closed == 1


async def test_plugging_in_can_be_awaited() -> None:
    inlet: SharedInlet[int] = SharedInlet("microphone")
    waiting = asyncio.create_task(inlet.plugged())
    await settle()
    assert not waiting.done()
    inlet.plug("a", FedSource())
    await waiting
    await inlet.plugged()


async def test_a_reader_that_goes_while_nothing_comes_leaves_nothing_behind() -> None:
    inlet: SharedInlet[int] = SharedInlet("microphone")
    source: FedSource[int] = FedSource()
    inlet.plug("a", source)
    before = asyncio.all_tasks()
    async with inlet.subscribe():
        await settle()
    await settle()
    assert source.opened == source.closed == 1
    assert asyncio.all_tasks() == before


class _SlowToEnd:
    """A source whose reader ends only when it may, as one that waits in another task."""

    def __init__(self) -> None:
        self.may_end = asyncio.Event()
        self.is_ending = asyncio.Event()

    @asynccontextmanager
    async def open(self) -> AsyncIterator[AsyncIterator[int]]:
        async with aclosing(self._items()) as items:
            yield items

    async def _items(self) -> AsyncGenerator[int, None]:
        try:
            await asyncio.get_running_loop().create_future()
            yield 0
        finally:
            self.is_ending.set()
            await self.may_end.wait()


async def test_a_reader_that_leaves_while_a_sender_is_being_unplugged_is_heard(
    caplog: pytest.LogCaptureFixture,
) -> None:
    inlet: SharedInlet[int] = SharedInlet("camera")
    source, following = _SlowToEnd(), FedSource[int]()
    inlet.plug("a", source)
    before = asyncio.all_tasks()
    async with inlet.subscribe():
        await settle()
        inlet.plug("b", following)
        await source.is_ending.wait()
        asyncio.get_running_loop().call_soon(source.may_end.set)
    assert (following.opened, caplog.messages) == (0, [])
    assert asyncio.all_tasks() == before
