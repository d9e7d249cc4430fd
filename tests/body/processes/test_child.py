import asyncio
import logging
import os
import sys
from asyncio.subprocess import PIPE, Process
from pathlib import Path

import pytest
from openrois_body.processes.child import MAX_LINE, MAX_LINES, Output, child_process, ended_within
from openrois_streaming.clock import SystemClock

from tests.support.streaming import VirtualClock, settle


@pytest.fixture(autouse=True)
def _log_all(caplog: pytest.LogCaptureFixture) -> None:
    caplog.set_level(logging.INFO, "openrois_body.processes.child")


async def test_output_is_logged_by_lines_however_it_arrives(caplog: pytest.LogCaptureFixture) -> None:
    output, stream = Output("puppet", VirtualClock()), asyncio.StreamReader()
    for piece in (b"one\r\nt", b"wo\n\xff\n", b"the end"):
        stream.feed_data(piece)
    stream.feed_eof()
    await output.read(stream)
    assert caplog.messages == ["puppet: one", "puppet: two", "puppet: \ufffd", "puppet: the end"]
    assert output.last_words == "one / two / \ufffd / the end"


async def test_a_flood_is_counted_second_by_second(caplog: pytest.LogCaptureFixture) -> None:
    clock = VirtualClock()
    output, stream = Output("puppet", clock), asyncio.StreamReader()
    reading = asyncio.create_task(output.read(stream))
    stream.feed_data(b"line\n" * (MAX_LINES + 7))
    await settle()
    assert caplog.messages == ["puppet: line"] * MAX_LINES
    await clock.advance(1)
    stream.feed_data(b"next\n")
    await settle()
    assert caplog.messages[MAX_LINES:] == ["puppet: 7 more lines", "puppet: next"]
    stream.feed_data(b"line\n" * (MAX_LINES + 1))
    stream.feed_eof()
    await reading
    assert caplog.messages[-1] == "puppet: 2 more lines"


async def test_a_line_without_an_end_costs_neither_memory_nor_the_log(caplog: pytest.LogCaptureFixture) -> None:
    output, stream = Output("puppet", VirtualClock()), asyncio.StreamReader()
    reading = asyncio.create_task(output.read(stream))
    for _ in range(50):
        stream.feed_data(b"x" * 10_000)
        await settle()
    stream.feed_data(b"\nnext\n")
    stream.feed_eof()
    await reading
    assert caplog.messages == ["puppet: " + "x" * MAX_LINE, "puppet: next"]


def output() -> Output:
    return Output("child", SystemClock())


def pipes(process: Process) -> tuple[asyncio.StreamWriter, asyncio.StreamReader]:
    assert process.stdin is not None
    assert process.stdout is not None
    return process.stdin, process.stdout


@pytest.mark.engine
async def test_a_conversation_has_pipes_and_its_errors_are_logged(caplog: pytest.LogCaptureFixture) -> None:
    async with asyncio.timeout(60), child_process("json.tool", output=output(), conversation=True) as process:
        into, out = pipes(process)
        into.write(b"[1]")
        into.close()
        assert await out.read() == b"[\n    1\n]\n"
        assert await ended_within(process, 5)
        assert process.returncode == 0
    async with asyncio.timeout(60), child_process("json.tool", output=output(), conversation=True) as process:
        into, _ = pipes(process)
        into.write(b"[")
        into.close()
        assert await ended_within(process, 5)
    assert caplog.messages == ["child: Expecting value: line 1 column 2 (char 1)"]


@pytest.mark.engine
async def test_a_child_gets_its_arguments_and_variables_and_nothing_of_the_working_directory(
    caplog: pytest.LogCaptureFixture, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("types", "timeit", "openrois_avatar"):
        (tmp_path / f"{name}.py").write_text("raise SystemExit('another file of this name')")
    monkeypatch.chdir(tmp_path)
    arguments = ("-n1", "-r1", "import os; print(os.environ['X'])")
    running = child_process("timeit", *arguments, output=output(), environment={"X": "y"})
    async with asyncio.timeout(60), running as process:
        assert await ended_within(process, 5)
    assert caplog.messages[0] == "child: y"


@pytest.mark.engine
async def test_a_child_that_runs_on_is_ended() -> None:
    async with asyncio.timeout(60), child_process("http.server", "0", output=output()) as process:
        assert not await ended_within(process, 0)
    assert process.returncode == -15


@pytest.mark.engine
async def test_a_child_is_ended_although_its_owner_is_cancelled_twice() -> None:
    started: list[Process] = []

    async def own() -> None:
        # It ends by the second signal alone.
        arguments = (
            "-n1",
            "import signal, time; signal.signal(15, signal.SIG_IGN); print(1, flush=True); time.sleep(60)",
        )
        async with child_process("timeit", *arguments, output=Output("child", SystemClock(), said)) as process:
            started.append(process)
            await asyncio.Event().wait()

    deaf = asyncio.Event()

    def said(_line: str) -> None:
        deaf.set()

    async with asyncio.timeout(60):
        owner = asyncio.create_task(own())
        await deaf.wait()
        owner.cancel()
        await settle()
        owner.cancel()
        await asyncio.wait({owner})
    assert owner.cancelled()
    assert started[0].returncode == -9


@pytest.mark.engine
async def test_unread_output_of_a_child_does_not_keep_its_pipe_open() -> None:
    arguments = ("-n1", "-r1", "import sys; sys.stdout.write('x' * 10_000_000)")
    running = child_process("timeit", *arguments, output=output(), conversation=True)
    async with asyncio.timeout(60), running as process:
        _, out = pipes(process)
        assert await out.readexactly(1) == b"x"
    assert out.at_eof()


@pytest.mark.engine
async def test_a_child_whose_parent_is_gone_already_does_not_start() -> None:
    process = await asyncio.create_subprocess_exec(
        sys.executable, "-m", "openrois_body.processes.launch", str(os.getppid()), "this", stdout=PIPE, stderr=PIPE
    )
    async with asyncio.timeout(60):
        assert await process.communicate() == (b"", b"the parent has ended already\n")
    assert process.returncode == 1
