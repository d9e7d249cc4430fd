"""A demo's program that hangs: it sends no sign of life any more."""

import asyncio
import logging
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, suppress
from pathlib import Path

import pytest
from openrois_demo.life_signs import LifeSigns

from openrois.aio.supervisor import Supervisor
from tests.support.conversing import until


class Watched:
    """Stands in for a program."""

    name = "mind"

    def __init__(self) -> None:
        self.runs = 1
        self.kills = 0

    def kill(self) -> None:
        self.kills += 1


class Time:
    """Passes when a test says so."""

    def __init__(self) -> None:
        self.waiting = 0
        self.passes = asyncio.Event()

    async def sleep(self, _seconds: float) -> None:
        self.waiting += 1
        await self.passes.wait()
        self.passes.clear()


@asynccontextmanager
async def watching(folder: Path) -> AsyncIterator[tuple[Supervisor, Watched, Time]]:
    time, program = Time(), Watched()
    signs = LifeSigns(folder / "signs", time.sleep)
    task = asyncio.ensure_future(signs.watch(program))
    try:
        await until((folder / "signs").exists)
        yield Supervisor(signs.environment), program, time
    finally:
        task.cancel()
        with suppress(asyncio.CancelledError):
            await task


async def test_a_program_that_was_alive_and_is_silent_is_killed_and_that_is_told(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    async with watching(tmp_path) as (supervisor, program, time):
        supervisor.notify_state("WATCHDOG=1")
        await until(lambda: time.waiting == 1)
        supervisor.notify_state("WATCHDOG=1")
        await until(lambda: time.waiting == 2)
        with caplog.at_level(logging.WARNING):
            time.passes.set()
            await until(lambda: program.kills == 1)
        assert "mind runs but does not answer: it is killed, and started again" in caplog.messages
        # The next process is watched from its first sign on.
        time.passes.set()
        supervisor.notify_state("WATCHDOG=1")
        await until(lambda: program.kills == 2)


async def test_a_program_that_begins_again_may_be_silent_for_that_time(tmp_path: Path) -> None:
    async with watching(tmp_path) as (supervisor, program, time):
        supervisor.notify_state("WATCHDOG=1")
        await until(lambda: time.waiting == 1)
        program.runs += 1
        time.passes.set()
        await until(lambda: not time.passes.is_set())
        supervisor.notify_state("WATCHDOG=1")
        await until(lambda: time.waiting == 2)
        assert program.kills == 0


async def test_without_a_socket_it_is_told_what_is_lost_and_the_program_runs_on(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    program, path = Watched(), tmp_path / ("long" * 30) / "signs"
    path.parent.mkdir()
    signs = LifeSigns(path)
    await signs.watch(program)
    (told,) = caplog.messages
    assert told.startswith(f"a mind that hangs is not noticed: no socket can be made at {path} (AF_UNIX path too long)")
    assert "set TMPDIR to a short path" in told
    # The program sends its signs to where nothing is.
    Supervisor(signs.environment).notify_state("WATCHDOG=1")
    assert program.kills == 0
