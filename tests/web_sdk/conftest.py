"""The TypeScript SDK as a package, built once, and applications of it in a Node of their own."""

import asyncio
import json
import os
import subprocess
from collections.abc import AsyncIterator, Callable
from contextlib import AbstractAsyncContextManager, asynccontextmanager
from pathlib import Path
from typing import Any

import pytest

HERE = Path(__file__).parent
WEB_DEMO = HERE.parents[1] / "web_demo"
PATIENCE = 20.0
"""Seconds; Node starts in one where nothing else runs."""

Start = Callable[..., AbstractAsyncContextManager["Application"]]


class Application:
    """A program on the SDK: it prints JSON lines, and waits for a line of input to go on."""

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

    async def go_on(self) -> None:
        """Let it go on."""
        assert self._process.stdin is not None
        self._process.stdin.write(b"\n")
        await self._process.stdin.drain()

    async def ends(self) -> None:
        """Wait until it has exited with 0."""
        async with asyncio.timeout(PATIENCE):
            assert await self._process.wait() == 0, await self._complaint()

    async def _complaint(self) -> str:
        assert self._process.stderr is not None
        async with asyncio.timeout(PATIENCE):
            return (await self._process.stderr.read()).decode()


@pytest.fixture(scope="session")
def package(node: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of the built package."""
    folder = tmp_path_factory.mktemp("openrois")
    subprocess.run([node, "build.mjs", "--package", folder], cwd=WEB_DEMO, check=True, timeout=60)
    return folder


@pytest.fixture
def start(node: Path, package: Path) -> Start:
    """Run a program of this folder against the gateway at an address."""

    @asynccontextmanager
    async def run(program: str, gateway: str, *flags: str, token: str = "") -> AsyncIterator[Application]:
        process = await asyncio.create_subprocess_exec(
            node,
            *flags,
            HERE / program,
            gateway,
            stdin=asyncio.subprocess.PIPE,
            stdout=asyncio.subprocess.PIPE,
            stderr=asyncio.subprocess.PIPE,
            env=os.environ | {"OPENROIS_SDK": str(package), "WEB_DEMO": str(WEB_DEMO), "TOKEN": token},
        )
        try:
            yield Application(process)
        finally:
            if process.returncode is None:
                process.kill()
            await process.communicate()

    return run
