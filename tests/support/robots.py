"""Simulators of robots in processes of their own, and waiting for what robots do."""

import asyncio
import os
import signal
import sys
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import asynccontextmanager, suppress
from typing import Self

__all__ = ["PATIENCE", "RobotProcess", "ended", "until"]

PATIENCE = 30.0
"""Seconds that anything may take on a busy machine."""


async def until(holds: Callable[[], object], patience: float = PATIENCE) -> None:
    """Wait until something holds that tells of no event."""
    async with asyncio.timeout(patience):
        while not holds():  # noqa: ASYNC110 - it tells of no event
            await asyncio.sleep(0.005)


async def ended(work: Awaitable[object]) -> BaseException | None:
    """Return what a work raises; None where it raises nothing."""
    (outcome,) = await asyncio.gather(work, return_exceptions=True)
    return outcome if isinstance(outcome, BaseException) else None


class RobotProcess:
    """A simulator in a process of its own, which can be frozen, killed and started again at its port."""

    def __init__(self, process: asyncio.subprocess.Process, port: int, module: str, options: tuple[str, ...]) -> None:
        self.process = process
        self.port = port
        self._module = module
        self._options = options

    @classmethod
    @asynccontextmanager
    async def running(cls, module: str, *options: str) -> AsyncIterator[Self]:
        """Run a module, which prints `ready HOST:PORT`."""
        made = cls(*await _launched(module, 0, options), module, options)
        try:
            yield made
        finally:
            await made.kill()

    def freeze(self) -> None:
        os.kill(self.process.pid, signal.SIGSTOP)

    def thaw(self) -> None:
        os.kill(self.process.pid, signal.SIGCONT)

    async def kill(self) -> None:
        with suppress(ProcessLookupError):
            self.process.kill()
        await self.process.wait()

    async def said(self) -> str:
        """Return what it printed as errors, once it has ended."""
        assert self.process.stderr is not None
        return (await self.process.stderr.read()).decode()

    async def start_again(self) -> None:
        self.process, _ = await _launched(self._module, self.port, self._options)


async def _launched(module: str, port: int, options: tuple[str, ...]) -> tuple[asyncio.subprocess.Process, int]:
    process = await asyncio.create_subprocess_exec(
        sys.executable,
        *("-m", module, "--port", str(port), *options),
        stdout=asyncio.subprocess.PIPE,
        stderr=asyncio.subprocess.PIPE,
    )
    assert process.stdout is not None
    async with asyncio.timeout(PATIENCE):
        ready = await process.stdout.readline()
    assert ready.startswith(b"ready "), ready
    return process, int(ready.rpartition(b":")[2])
