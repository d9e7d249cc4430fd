"""A program on one of our SDKs in a process of its own: it says what it saw as lines of JSON, and waits to go on."""

import asyncio
import json
import os
from collections.abc import AsyncIterator, Mapping
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any, Final

__all__ = ["JsonProgram", "json_program"]

PATIENCE: Final = 20.0
"""Seconds; Node and Mono start in one where nothing else runs."""


class JsonProgram:
    """A program on an SDK: it prints JSON lines, and waits for a line of input to go on."""

    def __init__(self, process: asyncio.subprocess.Process) -> None:
        self._process = process

    async def says(self, about: str) -> Any:
        """Return what it prints next, which must have this subject."""
        said = await self.says_something()
        assert said[0] == about, said
        return said[1]

    async def says_something(self) -> tuple[str, Any]:
        """Return subject and value of what it prints next."""
        assert self._process.stdout is not None
        async with asyncio.timeout(PATIENCE):
            line = await self._process.stdout.readline()
        assert line, f"it ended: {await self._complaint()}"
        said: dict[str, Any] = json.loads(line)
        ((about, what),) = said.items()
        return about, what

    async def go_on(self, line: str = "") -> None:
        """Let it go on, with a line of input."""
        assert self._process.stdin is not None
        self._process.stdin.write(f"{line}\n".encode())
        await self._process.stdin.drain()

    async def ends(self) -> None:
        """Wait until it has exited with 0."""
        async with asyncio.timeout(PATIENCE):
            assert await self._process.wait() == 0, await self._complaint()

    async def _complaint(self) -> str:
        assert self._process.stderr is not None
        async with asyncio.timeout(PATIENCE):
            return (await self._process.stderr.read()).decode()


@asynccontextmanager
async def json_program(*command: str | Path, environment: Mapping[str, str]) -> AsyncIterator[JsonProgram]:
    """Run a program while the block runs.

    Args:
        command: the program and its arguments.
        environment: variables beside those of this process.
    """
    process = await asyncio.create_subprocess_exec(
        *command,
        stdin=asyncio.subprocess.PIPE,
        stdout=asyncio.subprocess.PIPE,
        stderr=asyncio.subprocess.PIPE,
        limit=1 << 20,
        env=os.environ | environment,
    )
    try:
        yield JsonProgram(process)
    finally:
        if process.returncode is None:
            process.kill()
        await process.communicate()
