import asyncio
import logging
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import pytest
from openrois_streaming.source.fanout import DropOldest, Fanout, SourceEnded

from tests.support.streaming import FedSource, settle


@pytest.fixture
def source() -> FedSource[int]:
    return FedSource()


@pytest.fixture
def fanout(source: FedSource[int]) -> Fanout[int]:
    return Fanout(source, name="numbers")


async def test_the_source_is_open_from_the_first_reader_to_the_last(
    source: FedSource[int], fanout: Fanout[int]
) -> None:
    assert (source.is_open, fanout.running, fanout.readers) == (False, False, 0)
    async with fanout.subscribe() as first:
        await settle()
        assert (source.is_open, fanout.running, fanout.readers) == (True, True, 1)
        async with fanout.subscribe() as second:
            await source.feed(1)
            assert fanout.readers == 2
            assert await first.get() == 1
            assert await second.get() == 1
        assert (source.is_open, fanout.running, fanout.readers) == (True, True, 1)
    assert (source.is_open, fanout.running, fanout.readers) == (False, False, 0)
    assert source.opened == 1


async def test_nothing_is_pulled_after_the_last_reader_has_left(source: FedSource[int], fanout: Fanout[int]) -> None:
    async with fanout.subscribe():
        await source.feed(1, 2)
    await source.feed(3)
    assert source.pulled == 2
    assert fanout.pulled == 2


async def test_stalled_reader_loses_only_its_own_items(
    source: FedSource[int], fanout: Fanout[int], caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level(logging.INFO)
    taken = []
    async with fanout.subscribe() as fast:
        async with fanout.subscribe(maxsize=2) as stalled:
            for item in range(60):
                await source.feed(item)
                taken.append(await fast.get())
            assert [await stalled.get(), await stalled.get()] == [58, 59]
            assert (stalled.delivered, stalled.dropped) == (2, 58)
        assert taken == list(range(60))
        assert (fast.delivered, fast.dropped) == (60, 0)
    assert "took 2 and lost 58" in caplog.text


async def test_a_burst_reaches_a_reader_as_far_as_its_queue_goes(source: FedSource[int], fanout: Fanout[int]) -> None:
    async with fanout.subscribe(maxsize=3) as reader:
        source.feed_at_once(1, 2, 3, 4)
        await settle()
        assert [await reader.get() for _ in range(3)] == [2, 3, 4]


async def test_a_failure_reaches_every_reader_after_what_is_queued(source: FedSource[int], fanout: Fanout[int]) -> None:
    async with fanout.subscribe() as waiting, fanout.subscribe() as behind:
        await source.feed(1)
        assert await waiting.get() == 1
        waiter = asyncio.create_task(waiting.get())
        await settle()
        failure = OSError("the camera is gone")
        await source.end(failure)
        with pytest.raises(SourceEnded) as told:
            await waiter
        assert told.value.__cause__ is failure
        assert await behind.get() == 1
        for _ in range(2):
            with pytest.raises(SourceEnded) as told_again:
                await behind.get()
            assert told_again.value.__cause__ is failure
    assert not source.is_open


async def test_subscription_after_failure_reopens_the_source(source: FedSource[int], fanout: Fanout[int]) -> None:
    async with fanout.subscribe() as old:
        await source.end(OSError())
        assert not fanout.running
        async with fanout.subscribe() as new:
            await source.feed(5)
            assert await new.get() == 5
            assert source.opened == 2
            with pytest.raises(SourceEnded):
                await old.get()
    assert source.closed == 2


async def test_a_reader_of_a_failed_opening_leaves_without_closing_the_next(
    source: FedSource[int], fanout: Fanout[int]
) -> None:
    old = await fanout.subscribe().__aenter__()
    await source.end(OSError())
    async with fanout.subscribe() as new:
        await old.__aexit__(None, None, None)
        await source.feed(5)
        assert await new.get() == 5


async def test_the_end_of_a_source_is_no_failure(source: FedSource[int], fanout: Fanout[int]) -> None:
    async with fanout.subscribe() as reader:
        await source.end()
        with pytest.raises(SourceEnded) as told:
            await reader.get()
        assert told.value.__cause__ is None
        async with fanout.subscribe() as late:
            await source.feed(1)
            assert await late.get() == 1


async def test_failed_opening_ends_the_readers(fanout: Fanout[int], source: FedSource[int]) -> None:
    source.refusal = PermissionError("no access")
    async with fanout.subscribe() as reader:
        with pytest.raises(SourceEnded) as told:
            await reader.get()
        assert told.value.__cause__ is source.refusal


async def test_a_source_that_is_tried_again_logs_its_first_failure_each_other_reason_and_its_recovery(
    fanout: Fanout[int], source: FedSource[int], caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level(logging.INFO)

    async def fail(text: str) -> None:
        source.refusal = OSError(text)
        async with fanout.subscribe() as reader:
            with pytest.raises(SourceEnded):
                await reader.get()

    async def recover() -> None:
        source.refusal = None
        async with fanout.subscribe() as reader:
            for item in range(3):
                await source.feed(item)
                assert await reader.get() == item

    for text in ("no camera", "no camera", "no camera", "no access", "no access"):
        await fail(text)
    for _ in range(2):
        await recover()
    await fail("no access")
    assert [record.getMessage() for record in caplog.records] == [
        "numbers: the source failed: OSError('no camera')",
        "numbers: the source failed: OSError('no access')",
        "numbers: the source works again",
        "numbers: the source failed: OSError('no access')",
    ]
    assert fanout.failure is source.refusal


class _Stubborn:
    """Closes only when the test lets it, whatever happens to the task that closes it."""

    def __init__(self) -> None:
        self.open_now = 0
        self.most_open = 0
        self.may_close = asyncio.Event()

    @asynccontextmanager
    async def open(self) -> AsyncIterator[AsyncIterator[int]]:
        self.open_now += 1
        self.most_open = max(self.most_open, self.open_now)
        try:
            yield self._items()
        finally:
            await self.may_close.wait()
            self.open_now -= 1

    async def _items(self) -> AsyncIterator[int]:
        yield 1
        await asyncio.get_running_loop().create_future()


async def test_a_source_that_does_not_close_is_not_waited_for_for_ever_and_never_opened_twice(
    caplog: pytest.LogCaptureFixture,
) -> None:
    source = _Stubborn()
    fanout = Fanout(source, name="stubborn", close_timeout=0)
    async with fanout.subscribe() as first:
        assert await first.get() == 1
    assert "not closed after 0.0 s" in caplog.text
    async with fanout.subscribe():
        # Comes and goes while the source still closes.
        await settle()
    async with fanout.subscribe() as third:
        await settle()
        assert source.open_now == 1
        source.may_close.set()
        assert await third.get() == 1
        assert source.most_open == 1
    await settle()
    assert source.open_now == 0


async def test_a_reader_that_is_cancelled_while_it_leaves_leaves_no_open_source() -> None:
    source = _Stubborn()
    fanout = Fanout(source, name="stubborn")

    async def read() -> None:
        async with fanout.subscribe() as reader:
            while True:
                await reader.get()

    before = asyncio.all_tasks()
    reading = asyncio.ensure_future(read())
    await settle()
    for _ in range(3):
        reading.cancel()
        await settle()
    assert source.open_now == 1
    assert not reading.done()
    source.may_close.set()
    with pytest.raises(asyncio.CancelledError):
        await reading
    assert source.open_now == 0
    assert asyncio.all_tasks() == before


async def test_failure_while_closing_is_not_the_cause_of_the_end() -> None:
    class Brittle(FedSource[int]):
        @asynccontextmanager
        async def open(self) -> AsyncIterator[AsyncIterator[int]]:
            try:
                async with super().open() as items:
                    yield items
            finally:
                raise ValueError("cannot be closed")

    source = Brittle()
    fanout = Fanout(source, name="brittle")
    failure = OSError("the camera is gone")
    async with fanout.subscribe() as reader:
        await source.end(failure)
        with pytest.raises(SourceEnded) as told:
            await reader.get()
        await settle()
    assert told.value.__cause__ is fanout.failure is failure


async def test_failure_reaches_readers_before_the_source_closes() -> None:
    class Failing(_Stubborn):
        async def _items(self) -> AsyncIterator[int]:
            async for _ in super()._items():
                raise OSError
            yield 0

    source = Failing()
    fanout = Fanout(source, name="failing")
    async with fanout.subscribe() as reader:
        with pytest.raises(SourceEnded):
            await reader.get()
        assert source.open_now == 1
        source.may_close.set()


async def test_a_source_whose_task_is_cancelled_from_inside_ends_for_its_readers(
    fanout: Fanout[int], source: FedSource[int]
) -> None:
    source.refusal = asyncio.CancelledError()
    async with fanout.subscribe() as reader:
        with pytest.raises(SourceEnded):
            await reader.get()


async def test_a_reader_whose_wait_is_cancelled_can_read_on(source: FedSource[int], fanout: Fanout[int]) -> None:
    async with fanout.subscribe() as reader:
        waiter = asyncio.create_task(reader.get())
        await settle()
        waiter.cancel()
        await settle()
        await source.feed(1)
        assert await reader.get() == 1


async def test_an_item_that_comes_as_the_wait_is_cancelled_is_not_lost(
    source: FedSource[int], fanout: Fanout[int]
) -> None:
    async with fanout.subscribe() as reader:
        waiter = asyncio.create_task(reader.get())
        await settle()
        reader._put(1)
        waiter.cancel()
        with pytest.raises(asyncio.CancelledError):
            await waiter
        assert await reader.get() == 1
        assert reader.delivered == 1


async def test_a_subscription_has_one_reader_inside_its_context(source: FedSource[int], fanout: Fanout[int]) -> None:
    subscription = fanout.subscribe()
    with pytest.raises(RuntimeError, match="inside its `async with`"):
        await subscription.get()
    async with subscription:
        with pytest.raises(RuntimeError, match="entered only once"):
            await subscription.__aenter__()
        waiter = asyncio.create_task(subscription.get())
        await settle()
        with pytest.raises(RuntimeError, match="by one task"):
            await subscription.get()
    with pytest.raises(RuntimeError, match="inside its `async with`"):
        await waiter
    with pytest.raises(RuntimeError, match="inside its `async with`"):
        await subscription.get()


def test_a_mailbox_holds_at_least_one_item() -> None:
    with pytest.raises(ValueError, match="maxsize must be 1 or more, not 0"):
        DropOldest[int](0)
