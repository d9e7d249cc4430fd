"""Tasks and their parent."""

import asyncio
import logging

import pytest

from openrois.aio.tasks import Deadline, TaskScope


async def test_leaving_the_block_cancels_and_awaits_what_runs() -> None:
    ended: list[str] = []

    async def work() -> None:
        try:
            await asyncio.Event().wait()
        finally:
            await asyncio.sleep(0)
            ended.append("work")

    async with TaskScope() as tasks:
        tasks.start(work())
        await asyncio.sleep(0)
        assert len(tasks) == 1
    assert (ended, len(tasks)) == (["work"], 0)


async def test_a_failure_ends_one_task_and_is_logged(caplog: pytest.LogCaptureFixture) -> None:
    async def fail() -> None:
        raise ZeroDivisionError("why")

    async def other() -> None:
        await asyncio.sleep(0)

    async with TaskScope() as tasks:
        failed, fine = tasks.start(fail()), tasks.start(other())
        await asyncio.wait({failed, fine})
        assert fine.exception() is None
    (record,) = caplog.records
    assert record.levelno == logging.ERROR
    assert "why" in caplog.text


async def test_what_is_started_while_the_block_is_left_ends_too() -> None:
    ended: list[str] = []

    async def last_words() -> None:
        try:
            await asyncio.Event().wait()
        finally:
            ended.append("last words")

    async with TaskScope() as tasks:

        async def work() -> None:
            try:
                await asyncio.Event().wait()
            finally:
                tasks.start(last_words())
                await asyncio.sleep(0)

        tasks.start(work())
        await asyncio.sleep(0)
    assert ended == ["last words"]
    assert len(tasks) == 0


async def test_nothing_starts_without_a_parent() -> None:
    async def work() -> None:
        raise AssertionError("must not run")

    async with TaskScope() as tasks:
        pass
    with pytest.raises(RuntimeError):
        tasks.start(work())


async def test_an_error_in_the_block_passes_through() -> None:
    tasks = TaskScope()

    async def fail() -> None:
        async with tasks:
            tasks.start(asyncio.sleep(60))
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        await fail()
    assert len(tasks) == 0


class TestDeadline:
    async def test_what_ends_in_time_ends_as_it_would(self) -> None:
        with Deadline(60):
            await asyncio.sleep(0)
        with pytest.raises(KeyError), Deadline(60):
            raise KeyError

    async def test_what_takes_too_long_is_cancelled_and_times_out(self) -> None:
        with pytest.raises(TimeoutError), Deadline(0):
            await asyncio.Event().wait()
        task = asyncio.current_task()
        assert task is not None
        assert task.cancelling() == 0
        await asyncio.sleep(0)

    async def test_what_ends_with_its_time_has_timed_out_only_if_it_was_stopped(self) -> None:
        async def work() -> None:
            try:
                await asyncio.Event().wait()
            except asyncio.CancelledError:
                raise KeyError from None

        with pytest.raises(KeyError), Deadline(0):
            await work()

    async def test_a_task_that_is_also_cancelled_ends(self) -> None:
        entered = asyncio.Event()

        async def work() -> None:
            with Deadline(60):
                entered.set()
                await asyncio.Event().wait()

        task = asyncio.ensure_future(work())
        await entered.wait()
        task.cancel()
        with pytest.raises(asyncio.CancelledError):
            await task

    async def test_both_at_once(self) -> None:
        async def work() -> None:
            with Deadline(0):
                await asyncio.Event().wait()

        task = asyncio.ensure_future(work())
        loop = asyncio.get_running_loop()
        await asyncio.sleep(0)
        loop.call_later(0, task.cancel)
        with pytest.raises((asyncio.CancelledError, TimeoutError)):
            await task
