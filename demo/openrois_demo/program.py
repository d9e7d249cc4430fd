"""A sub-command of `openrois` as a supervised child process: started, observed, restarted, and ended."""

import asyncio
import logging
import os
import signal
import time
from collections.abc import Awaitable, Callable, Mapping
from contextlib import suppress
from types import MappingProxyType
from typing import Final

from openrois_avatar.link.private_path import remove_abandoned
from openrois_body.processes.launch import command_line

from openrois.transport.backoff import Backoff

__all__ = ["LONGEST_PAUSE", "Program", "ProgramFailed"]

_log = logging.getLogger(__name__)

STOP_TIMEOUT: Final = 2.0
"""Seconds that a program has to end by itself before it is killed, with all that it started."""

LONGEST_PAUSE: Final = 5.0
"""Longest delay before a restart in seconds: a person waits for it."""


class ProgramFailed(Exception):
    """A program that did not become ready; the text says why."""


class Program:
    """One sub-command of `openrois` and the process that runs it.

    Args:
        arguments: the sub-command and its arguments.
        announces: beginning of the line that it prints when it is ready.
        environment: added to the variables of this process.

    Attributes:
        name: the sub-command.
        ready: set once it was ready.
        runs: number of starts.
    """

    def __init__(
        self, arguments: tuple[str, ...], announces: str, environment: Mapping[str, str] = MappingProxyType({})
    ) -> None:
        self.name = arguments[0]
        self.ready = asyncio.Event()
        self.runs = 0
        self._process: asyncio.subprocess.Process | None = None
        self._arguments = arguments
        self._announces = announces
        self._environment = environment
        self._was_ready = False
        """Whether the process that ran last was."""

    async def keep_running(self, sleep: Callable[[float], Awaitable[None]] = asyncio.sleep) -> None:
        """Run the program until cancelled; once it was ready, a process that ends is restarted after a delay.

        Raises:
            ProgramFailed: it ended before it was ready for the first time.
        """
        backoff = Backoff(first=0.5, limit=LONGEST_PAUSE)
        while True:
            started = time.monotonic()
            status = await self._run_once()
            if not self.ready.is_set():
                raise ProgramFailed(
                    f"{self.name} ended with status {status} before it was ready; its log above says why"
                )
            if self._was_ready:
                _log.warning("%s ended with status %s and is started again", self.name, status)
            else:
                _log.warning(
                    "%s ended with status %s before it was ready again, and is started once more; its log above says"
                    " why: if it goes on like that end the demo with Ctrl-C, and mend what it says",
                    self.name,
                    status,
                )
            await sleep(backoff.after(time.monotonic() - started))

    def kill(self) -> None:
        """Kill the process that runs now, as it hangs; `keep_running` starts another."""
        if self._process is not None and self._process.returncode is None:
            with suppress(ProcessLookupError):
                self._process.kill()

    async def _run_once(self) -> int:
        process = await asyncio.create_subprocess_exec(
            *command_line("openrois.cli", *self._arguments),
            stdin=asyncio.subprocess.DEVNULL,
            stdout=asyncio.subprocess.PIPE,
            start_new_session=True,
            env={**os.environ, **self._environment},
        )
        self._process, self._was_ready = process, False
        self.runs += 1
        try:
            assert process.stdout is not None
            async for line in process.stdout:
                if line.decode(errors="replace").startswith(self._announces):
                    self._note_ready()
            return await process.wait()
        finally:
            await self._terminate_process(process)

    def _note_ready(self) -> None:
        if self.runs > 1 and not self._was_ready:
            _log.warning("%s is ready again", self.name)
        self._was_ready = True
        self.ready.set()

    async def _terminate_process(self, process: asyncio.subprocess.Process) -> None:
        if process.returncode is None:
            with suppress(ProcessLookupError):
                process.terminate()
            try:
                async with asyncio.timeout(STOP_TIMEOUT):
                    await process.wait()
            except TimeoutError:
                _log.warning("%s did not end within %.1f s and is killed", self.name, STOP_TIMEOUT)
        # It has a session of its own, so this reaches processes that it started and could not end.
        with suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
        await process.wait()
        # A killed process could not do so itself.
        remove_abandoned()
