"""The example with two bodies and their visitors, in any language: as a process, and what it has printed."""

import asyncio
import re
from collections.abc import AsyncIterator, Sequence
from contextlib import asynccontextmanager
from pathlib import Path

__all__ = ["Program", "running", "served"]


class Program:
    """An example that runs, and what it has printed."""

    def __init__(self, process: asyncio.subprocess.Process) -> None:
        self.lines: list[str] = []
        self._process = process
        self._news = asyncio.Event()

    async def read(self) -> None:
        """Read to its end, which must be a good one."""
        assert self._process.stdout is not None
        async for line in self._process.stdout:
            self.lines.append(line.decode().rstrip())
            self._news.set()
        assert await self._process.wait() == 0, self.lines

    async def says(self, words: str) -> None:
        """Wait until it prints a line with such words."""
        while not any(re.search(words, line) for line in self.lines):
            self._news.clear()
            await self._news.wait()


@asynccontextmanager
async def running(*command: str | Path) -> AsyncIterator[Program]:
    """Run a program; at the end of the block it has ended well."""
    process = await asyncio.create_subprocess_exec(
        *command, stdout=asyncio.subprocess.PIPE, stderr=asyncio.subprocess.STDOUT
    )
    try:
        program = Program(process)
        async with asyncio.TaskGroup() as tasks:
            tasks.create_task(program.read())
            yield program
    finally:
        if process.returncode is None:
            process.kill()
        await process.wait()


def served(lines: Sequence[str], visitors: Sequence[str]) -> list[str]:
    """Which body took care of each visitor; each was served once."""
    bodies = []
    for visitor in visitors:
        (body,) = (match[1] for line in lines if (match := re.fullmatch(rf"{visitor}: (\w+) took care", line)))
        bodies.append(body)
    return bodies
