"""A Reachy Mini's adapter in a process of its own, behind a real gateway."""

import asyncio
import sys
from asyncio.subprocess import Process
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import dataclass

from openrois_robots.reachy.daemon.address import Address

from tests.support.deployment import gateway
from tests.support.robots import PATIENCE

__all__ = ["Home", "home"]


@dataclass
class Home:
    """An adapter that runs, and the address of its gateway."""

    adapter: Process
    url: str


@asynccontextmanager
async def home(address: Address) -> AsyncIterator[Home]:
    """Run a gateway, and the adapter of a robot behind it as `reachy`."""
    async with gateway() as running:
        adapter = await asyncio.create_subprocess_exec(
            sys.executable,
            *("-m", "openrois.cli", "robot", "reachy", "--gateway", running.url, "--robot", address.text),
            stdout=asyncio.subprocess.PIPE,
        )
        try:
            assert adapter.stdout is not None
            async with asyncio.timeout(PATIENCE):
                assert await adapter.stdout.readline() == b"ready reachy\n"
            yield Home(adapter, running.url.replace("http", "ws", 1))
        finally:
            if adapter.returncode is None:
                adapter.kill()
            await adapter.wait()
