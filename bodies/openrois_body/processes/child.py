"""Child processes: they cannot outlive their parent, their output is logged, and they end within a bounded time."""

from __future__ import annotations

import asyncio
import logging
import os
import signal
from asyncio.subprocess import DEVNULL, PIPE, STDOUT, Process
from collections import deque
from collections.abc import AsyncIterator, Callable, Coroutine, Mapping
from contextlib import asynccontextmanager, suppress
from typing import Final

from openrois_streaming.clock import MediaClock

from openrois_body.processes.launch import command_line

TERMINATE_TIMEOUT: Final = 0.5
"""Seconds from SIGTERM to SIGKILL."""
OUTPUT_TIMEOUT: Final = 0.2
"""Seconds for the last lines of a child that has ended; longer only where a process of its own still holds the pipe."""
MAX_LINES: Final = 20
"""Lines of output per second that are logged; further lines are only counted."""
MAX_LINE: Final = 500
"""Bytes of a line that are logged."""
_REMEMBERED: Final = 5

_log = logging.getLogger(__name__)


@asynccontextmanager
async def child_process(
    module: str,
    *arguments: str,
    output: Output,
    environment: Mapping[str, str] | None = None,
    conversation: bool = False,
) -> AsyncIterator[Process]:
    """Run `python -P -m module` for as long as the context lasts; at its end the child is terminated, then killed.

    That is waited for, a second at most, also where the context's task is cancelled once more.

    The child is killed when this process dies, and does not get the terminal's Ctrl-C.

    Args:
        module: to run.
        arguments: its arguments.
        output: gets its output for people, to the last line.
        environment: variables in addition to those of this process.
        conversation: whether its stdin and stdout are pipes for messages; else stdin is empty and stdout is output.
    """
    process = await asyncio.create_subprocess_exec(
        *command_line(module, *arguments),
        stdin=PIPE if conversation else DEVNULL,
        stdout=PIPE,
        stderr=PIPE if conversation else STDOUT,
        env={**os.environ, **(environment or {})},
        start_new_session=True,
    )
    printed = process.stderr if conversation else process.stdout
    assert printed is not None
    reading = asyncio.create_task(output.read(printed), name=f"output of {module}")
    try:
        yield process
    finally:
        await _completed(_end(process, reading, conversation))


async def write_message(process: Process, message: bytes) -> None:
    """Write to a child that was started for a conversation.

    Raises:
        OSError: the child has ended, or reads no more.
    """
    assert process.stdin is not None
    if process.stdin.is_closing():
        # uvloop raises RuntimeError where asyncio drops the data.
        raise BrokenPipeError("the process has ended")
    process.stdin.write(message)
    await process.stdin.drain()


async def ended_within(process: Process, seconds: float) -> bool:
    """Wait until the process has ended by itself, `seconds` at most; return whether it has."""
    with suppress(TimeoutError):
        async with asyncio.timeout(seconds):
            await process.wait()
    return process.returncode is not None


async def _drop(stream: asyncio.StreamReader) -> None:
    """Discard the rest of a pipe: a full pipe is not read to its end by itself, and stays open."""
    # RuntimeError: another task is reading the pipe, and gets the rest.
    with suppress(TimeoutError, RuntimeError):
        async with asyncio.timeout(OUTPUT_TIMEOUT):
            while await stream.read(65536):
                pass


async def _completed(work: Coroutine[None, None, None]) -> None:
    """Do `work` to its end, however often the caller is cancelled meanwhile; it is cancelled afterwards."""
    working = asyncio.ensure_future(work)
    cancelled: asyncio.CancelledError | None = None
    while not working.done():
        try:
            await asyncio.wait((working,))
        except asyncio.CancelledError as error:
            cancelled = error
    working.result()
    if cancelled is not None:
        raise cancelled


async def _end(process: Process, reading: asyncio.Task[None], conversation: bool) -> None:
    await _terminate(process)
    if conversation and process.stdout is not None:
        await _drop(process.stdout)
    await asyncio.wait({reading}, timeout=OUTPUT_TIMEOUT)
    reading.cancel()


async def _terminate(process: Process) -> None:
    with suppress(ProcessLookupError):
        if process.returncode is None:
            process.terminate()
            await ended_within(process, TERMINATE_TIMEOUT)
        if process.returncode is None:
            os.killpg(process.pid, signal.SIGKILL)  # its session is its own
    await process.wait()


class Output:
    """The output of a child for people: its lines are logged at INFO, `MAX_LINES` a second; more are only counted.

    Args:
        name: of the child, in the log.
        clock: for the seconds.
        on_line: called with every line.
    """

    def __init__(self, name: str, clock: MediaClock, on_line: Callable[[str], None] | None = None) -> None:
        self._on_line = on_line
        self._last: deque[str] = deque(maxlen=_REMEMBERED)
        self._name = name
        self._clock = clock
        self._second = -1
        self._logged = 0
        self._suppressed = 0
        self._ended = asyncio.Event()

    async def all_said(self) -> None:
        """Wait for the last output of a child that has ended, `OUTPUT_TIMEOUT` at most."""
        with suppress(TimeoutError):
            async with asyncio.timeout(OUTPUT_TIMEOUT):
                await self._ended.wait()

    @property
    def last_words(self) -> str:
        """The last few lines, to say why a child has ended."""
        return " / ".join(self._last)

    async def read(self, stream: asyncio.StreamReader) -> None:
        """Log the lines of `stream` until it ends. A line without an end takes bounded memory."""
        rest = b""
        while data := await stream.read(65536):
            *lines, rest = (rest + data).split(b"\n")
            for line in lines:
                self._line(line)
            rest = rest[:MAX_LINE]
        if rest:
            self._line(rest)
        self._report()
        self._ended.set()

    def _line(self, line: bytes) -> None:
        text = line[:MAX_LINE].decode(errors="replace").rstrip()
        self._last.append(text)
        if self._on_line is not None:
            self._on_line(text)
        second = int(self._clock.now())
        if second != self._second:
            self._report()
            self._second, self._logged = second, 0
        if self._logged < MAX_LINES:
            self._logged += 1
            _log.info("%s: %s", self._name, text)
        else:
            self._suppressed += 1

    def _report(self) -> None:
        if self._suppressed:
            _log.info("%s: %d more lines", self._name, self._suppressed)
            self._suppressed = 0
