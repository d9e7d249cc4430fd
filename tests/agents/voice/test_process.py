"""Agents as processes: they end in time when they are told to, whatever state they are in."""

import asyncio
import signal
import sys
from asyncio.subprocess import PIPE, Process
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import pytest

from tests.support.loopback import PATIENCE
from tests.support.voice_agents import end_agent, running_agent

_PROGRAM = """
import asyncio, atexit, ctypes, hashlib, itertools, os, signal, threading
from openrois_agents.voice.process import run_agent

async def stubborn():
    while True:
        try:
            await asyncio.Event().wait()
        except asyncio.CancelledError:
            print("asked to end", flush=True)

def wait():
    # Locked twice: what waits in C sees no signal, and lets other threads run.
    lock = ctypes.create_string_buffer(64)
    ctypes.CDLL(None).pthread_mutex_lock(lock)
    print("waits", flush=True)
    ctypes.CDLL(None).pthread_mutex_lock(lock)

def compute():
    # For an hour, likewise.
    print("computes", flush=True)
    hashlib.pbkdf2_hmac("sha256", b"", b"", 2**31 - 1)

def hold():
    # For ever; nothing else runs in the interpreter meanwhile.
    print("holds", flush=True)
    sum(itertools.repeat(0))

def fork():
    if not os.fork():
        signal.signal(signal.SIGTERM, lambda *_: os._exit(0))
        signal.raise_signal(signal.SIGTERM)
    os.wait()

async def agent():
    print("running", flush=True)
    {work}

run_agent(agent(), within={within})
"""

RESTS = "await asyncio.Event().wait()"


@asynccontextmanager
async def agent(work: str, *before: str, within: float = PATIENCE) -> AsyncIterator[tuple[Process, str]]:
    """Run an agent whose work is a piece of Python, by a command before it; yields it, and the first line it prints."""
    program = _PROGRAM.format(work=work, within=within)
    process = await asyncio.create_subprocess_exec(*before, sys.executable, "-c", program, stdout=PIPE, stderr=PIPE)
    try:
        assert process.stdout is not None
        async with asyncio.timeout(PATIENCE):
            yield process, (await process.stdout.readline()).decode().strip()
    finally:
        if process.returncode is None:
            process.kill()
        await process.communicate()


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
async def test_an_agent_that_is_told_to_end_cleans_up(number: signal.Signals) -> None:
    async with agent(f"try: {RESTS}\n    finally: print('cleaned up', flush=True)") as (process, said):
        assert said == "running"
        process.send_signal(number)
        told, complaint = await process.communicate()
        assert (process.returncode, told, complaint) == (0, b"cleaned up\n", b"")


@pytest.mark.parametrize(
    "work",
    [
        pytest.param("await stubborn()", id="its main task goes on"),
        pytest.param(f"task = asyncio.ensure_future(stubborn()); {RESTS}", id="another task goes on"),
        pytest.param("while True: pass", id="the event loop does not come to run"),
        pytest.param(f"threading.Thread(target=threading.Event().wait).start(); {RESTS}", id="a thread waits"),
        pytest.param(f"atexit.register(hold); {RESTS}", id="a library holds the interpreter at the end of the process"),
    ],
)
async def test_an_agent_that_does_not_end_is_ended_and_it_is_said_where_it_was(work: str) -> None:
    async with agent(work, within=1.0) as (process, said):
        assert said == "running"
        process.send_signal(signal.SIGINT)
        _, complaint = await process.communicate()
        assert process.returncode == 1
        assert complaint.startswith(b"Timeout (0:00:01)!\n")
        assert b'File "<string>", line' in complaint or b"threading.py" in complaint


@pytest.mark.parametrize("library", ["wait", "compute"])
async def test_an_agent_is_ended_also_while_a_library_lets_no_handler_of_signals_run(library: str) -> None:
    async with agent(f"{library}()", within=1.0) as (process, _):
        assert process.stdout is not None
        assert await process.stdout.readline() == f"{library}s\n".encode()
        process.send_signal(signal.SIGINT)
        _, complaint = await process.communicate()
        assert process.returncode == 1
        assert complaint.startswith(b"Timeout (0:00:01)!\n")
        assert f"in {library}\n".encode() in complaint


async def test_sigquit_ends_it_where_a_library_holds_the_interpreter() -> None:
    # What runs the tests in the background may ignore the signal, and a core file is of no use here.
    default = "import os, resource, signal, sys; signal.signal(signal.SIGQUIT, signal.SIG_DFL);"
    default += " resource.setrlimit(resource.RLIMIT_CORE, (0, 0)); os.execvp(sys.argv[1], sys.argv[1:])"
    async with agent("hold()", sys.executable, "-c", default) as (process, _):
        assert process.stdout is not None
        assert await process.stdout.readline() == b"holds\n"
        process.send_signal(signal.SIGQUIT)
        await process.communicate()
        assert process.returncode == -signal.SIGQUIT


async def test_an_agent_that_fails_is_ended_too() -> None:
    work = "threading.Thread(target=threading.Event().wait).start(); raise ValueError('no such body')"
    async with agent(work, within=1.0) as (process, said):
        assert said == "running"
        _, complaint = await process.communicate()
        assert process.returncode == 1
        assert b"ValueError: no such body" in complaint
        assert b"Timeout (0:00:01)!" in complaint


async def test_a_signal_counts_where_the_process_was_started_with_it_ignored() -> None:
    ignoring = "sh", "-c", 'trap "" INT; exec "$@"', "sh"
    async with agent(RESTS, *ignoring) as (process, said):
        assert said == "running"
        process.send_signal(signal.SIGINT)
        await process.communicate()
        assert process.returncode == 0


async def test_a_second_signal_ends_it_at_once() -> None:
    async with agent("await stubborn()", within=2 * PATIENCE) as (process, _):
        process.send_signal(signal.SIGINT)
        assert process.stdout is not None
        assert await process.stdout.readline() == b"asked to end\n"
        process.send_signal(signal.SIGINT)
        await process.communicate()
        assert process.returncode == -signal.SIGINT


async def test_a_second_signal_ends_it_at_once_also_while_a_library_lets_no_handler_run() -> None:
    async with agent("wait()", within=2 * PATIENCE) as (process, _):
        assert process.stdout is not None
        assert await process.stdout.readline() == b"waits\n"
        # Two of the same kind may become one.
        process.send_signal(signal.SIGINT)
        process.send_signal(signal.SIGTERM)
        await process.communicate()
        assert process.returncode in (128 + signal.SIGINT, 128 + signal.SIGTERM)


async def test_a_signal_to_a_process_that_the_agent_has_forked_is_none_to_it() -> None:
    async with agent("fork(); wait()", within=1.0) as (process, _):
        assert process.stdout is not None
        assert await process.stdout.readline() == b"waits\n"
        process.send_signal(signal.SIGINT)
        await process.communicate()
        # A second signal would have ended it at once.
        assert process.returncode == 1


async def test_an_agent_that_goes_on_after_a_test_is_killed_and_the_test_fails() -> None:
    deaf = "import signal; signal.signal(signal.SIGINT, signal.SIG_IGN); print(flush=True); signal.pause()"
    process = await asyncio.create_subprocess_exec(sys.executable, "-c", deaf, stdout=PIPE)
    assert process.stdout is not None
    await process.stdout.readline()
    with pytest.raises(AssertionError, match=r"the agent was killed: it went on for 0\.1 s after SIGINT"):
        await end_agent(process, 0.1)
    assert process.returncode == -signal.SIGKILL
    with pytest.raises(AssertionError, match="the agent has ended with status 3"):
        async with running_agent("-c", "raise SystemExit(3)") as other:
            await other.wait()
