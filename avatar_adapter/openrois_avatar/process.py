"""A sub-command of `openrois` as a child process that is watched: started, listened to, started again, and ended."""

import asyncio
import logging
import os
import signal
import time
from collections.abc import Awaitable, Callable
from contextlib import suppress
from typing import Final

from openrois.transport.backoff import Backoff
from openrois_avatar.launch import command_line
from openrois_avatar.link.private import remove_abandoned

__all__ = ["LONGEST_PAUSE", "Program", "ProgramFailed"]

_log = logging.getLogger(__name__)

STOP_TIMEOUT: Final = 2.0
"""Seconds that a program has to end by itself before it is killed, with whatever it started."""

LONGEST_PAUSE: Final = 5.0
"""Seconds before a program that ends again and again is started once more: a person waits for it."""


class ProgramFailed(Exception):
    """A program did not become ready; the text says how."""


class Program:
    """One sub-command of `openrois` and the process that runs it.

    Args:
        arguments: the sub-command and its arguments.
        announces: how the line begins that it prints when it is ready.

    Attributes:
        name: the sub-command.
        ready: it was ready once.
        runs: how often it was started.
    """

    def __init__(self, arguments: tuple[str, ...], announces: str) -> None:
        self.name = arguments[0]
        self.ready = asyncio.Event()
        self.runs = 0
        self._process: asyncio.subprocess.Process | None = None
        self._arguments = arguments
        self._announces = announces

    async def keep_running(self, sleep: Callable[[float], Awaitable[None]] = asyncio.sleep) -> None:
        """Run it until cancelled; once it was ready, a process that ends is replaced, after a while.

        Raises:
            ProgramFailed: it ended before it was ready for the first time.
        """
        backoff = Backoff(first=0.5, limit=LONGEST_PAUSE)
        while True:
            started = time.monotonic()
            status = await self._run_once()
            if not self.ready.is_set():
                raise ProgramFailed(f"{self.name} ended with status {status} before it was ready")
            _log.warning("%s ended with status %s and is started again", self.name, status)
            await sleep(backoff.after(time.monotonic() - started))

    def kill(self) -> None:
        """End the process that runs now, which does not do what it should; `keep_running` starts another."""
        if self._process is not None and self._process.returncode is None:
            with suppress(ProcessLookupError):
                self._process.kill()

    async def _run_once(self) -> int:
        process = await asyncio.create_subprocess_exec(
            *command_line("openrois.cli", *self._arguments),
            stdin=asyncio.subprocess.DEVNULL,
            stdout=asyncio.subprocess.PIPE,
            start_new_session=True,
        )
        self._process = process
        self.runs += 1
        try:
            assert process.stdout is not None
            async for line in process.stdout:
                if line.decode(errors="replace").startswith(self._announces):
                    self.ready.set()
            return await process.wait()
        finally:
            await self._end(process)

    async def _end(self, process: asyncio.subprocess.Process) -> None:
        if process.returncode is None:
            with suppress(ProcessLookupError):
                process.terminate()
            try:
                async with asyncio.timeout(STOP_TIMEOUT):
                    await process.wait()
            except TimeoutError:
                _log.warning("%s did not end within %.1f s and is killed", self.name, STOP_TIMEOUT)
        # Its session is its own, so this reaches what it started and could not end.
        with suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
        await process.wait()
        # One that was killed could not do so itself.
        remove_abandoned()
