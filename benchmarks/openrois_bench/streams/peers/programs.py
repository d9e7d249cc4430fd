"""Programs that are asked by lines of JSON, and answer so."""

import asyncio
import json
from asyncio.subprocess import PIPE
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any

LINE_LIMIT = 1 << 20
PATIENCE = 30.0


class Child:
    """A program that runs."""

    def __init__(self, process: asyncio.subprocess.Process) -> None:
        self.process = process

    async def ask(self, **request: Any) -> dict[str, Any]:
        """Its answer.

        Raises:
            RuntimeError: it has ended.
            TimeoutError: it is silent.
        """
        assert self.process.stdin is not None
        assert self.process.stdout is not None
        self.process.stdin.write(json.dumps(request).encode() + b"\n")
        async with asyncio.timeout(PATIENCE):
            line = await self.process.stdout.readline()
        if not line:
            raise RuntimeError("a program that takes part has ended")
        answer: dict[str, Any] = json.loads(line)
        return answer


@asynccontextmanager
async def child(*command: str) -> AsyncIterator[Child]:
    """Run a program until the context is left; it ends with its input, or is killed."""
    process = await asyncio.create_subprocess_exec(*command, stdin=PIPE, stdout=PIPE, limit=LINE_LIMIT)
    try:
        yield Child(process)
    finally:
        assert process.stdin is not None
        process.stdin.close()
        try:
            async with asyncio.timeout(5):
                await process.wait()
        except TimeoutError:
            process.kill()
            await process.wait()
