import asyncio
import logging
import signal
from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager, suppress
from pathlib import Path

import psutil
import pytest
from openrois_demo import program as process
from openrois_demo.program import LONGEST_PAUSE, Program, ProgramFailed

from tests.support.streaming import settle

GATEWAY = ("gateway", "--port", "0")


class Pauses:
    """Stands in for `asyncio.sleep`: records the pauses, and lets a test hold them."""

    def __init__(self) -> None:
        self.lengths: list[float] = []
        self.begun = asyncio.Event()
        self.may_end = asyncio.Event()

    async def __call__(self, seconds: float) -> None:
        self.lengths.append(seconds)
        self.begun.set()
        await self.may_end.wait()
        self.may_end.clear()


@asynccontextmanager
async def running(program: Program, pauses: Pauses) -> AsyncIterator[asyncio.Task[None]]:
    task = asyncio.create_task(program.keep_running(pauses))
    try:
        yield task
    finally:
        task.cancel()
        with suppress(asyncio.CancelledError):
            await task


class Children:
    """The child processes of a test; not those that others have started before."""

    def __init__(self) -> None:
        self._others = set(psutil.Process().children())

    def now(self) -> list[psutil.Process]:
        return [child for child in psutil.Process().children() if child not in self._others]


@pytest.fixture(autouse=True)
def children() -> Iterator[Children]:
    """What a test starts; nothing of it may be left."""
    children = Children()
    yield children
    assert not children.now()


async def test_a_program_that_cannot_start_is_not_tried_again() -> None:
    with pytest.raises(ProgramFailed, match="nonsense ended with status 2 before it was ready"):
        await Program(("nonsense",), announces="ready ").keep_running(Pauses())


async def test_a_program_that_ends_is_started_again_after_growing_pauses() -> None:
    program, pauses = Program(("--version",), announces="openrois "), Pauses()
    async with running(program, pauses), asyncio.timeout(60):
        await pauses.begun.wait()
        assert program.ready.is_set()
        pauses.begun.clear()
        pauses.may_end.set()
        await pauses.begun.wait()
    assert pauses.lengths[0] == 0.5
    assert pauses.lengths[1] > 0.5


@pytest.mark.long
async def test_a_program_that_ends_again_and_again_is_started_after_five_seconds_at_most() -> None:
    program, pauses = Program(("--version",), announces="openrois "), Pauses()
    async with running(program, pauses), asyncio.timeout(100):
        while len(pauses.lengths) < 10:
            await pauses.begun.wait()
            pauses.begun.clear()
            pauses.may_end.set()
    assert pauses.lengths == sorted(pauses.lengths)
    assert pauses.lengths[-1] == LONGEST_PAUSE


async def test_a_program_that_is_killed_is_started_again_and_ends_when_it_is_told_to(
    children: Children, caplog: pytest.LogCaptureFixture, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # A user's file of such a name is left alone.
    (tmp_path / "types.py").write_text("raise SystemExit('taken')")
    monkeypatch.chdir(tmp_path)
    program, pauses = Program(GATEWAY, announces="listening "), Pauses()
    async with running(program, pauses), asyncio.timeout(60):
        await program.ready.wait()
        [first] = children.now()
        assert first.cmdline()[-3:] == list(GATEWAY)
        first.kill()
        await pauses.begun.wait()
        assert not children.now()
        program.ready.clear()
        pauses.may_end.set()
        await program.ready.wait()
        [second] = children.now()
        assert second != first
    assert [record.message for record in caplog.records if record.name == process.__name__] == [
        "gateway ended with status -9 and is started again",
        "gateway is ready again",
    ]


async def test_a_program_that_cannot_start_again_is_told_with_what_to_do(
    caplog: pytest.LogCaptureFixture, tmp_path: Path
) -> None:
    # It fails once the file is gone.
    file = tmp_path / "gateway.toml"
    file.write_text("")
    program, pauses = Program(("gateway", "--config", str(file), "--print-config"), announces=""), Pauses()
    async with running(program, pauses), asyncio.timeout(60):
        await pauses.begun.wait()
        file.unlink()
        pauses.begun.clear()
        pauses.may_end.set()
        await pauses.begun.wait()
    told = [record.message for record in caplog.records if record.name == process.__name__][-1]
    assert "gateway ended with status 2 before it was ready again" in told
    assert "end the demo with Ctrl-C" in told


async def test_a_program_that_does_not_end_by_itself_is_killed(
    children: Children, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr(process, "STOP_TIMEOUT", 0.05)
    program = Program(GATEWAY, announces="listening ")
    with caplog.at_level(logging.WARNING):
        async with running(program, Pauses()), asyncio.timeout(60):
            await program.ready.wait()
            children.now()[0].send_signal(signal.SIGSTOP)
    assert "gateway did not end within 0.1 s and is killed" in caplog.messages


async def test_a_program_that_is_told_to_end_before_it_is_ready_ends(children: Children) -> None:
    program = Program(GATEWAY, announces="never said ")
    async with running(program, Pauses()):
        await settle()
        assert children.now()
    assert not program.ready.is_set()
