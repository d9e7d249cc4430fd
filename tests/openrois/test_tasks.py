"""Tasks and their parent."""

import asyncio
import logging

import pytest

from openrois.tasks import TaskScope


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
