"""A graph of ROS over the loopback interface, in a domain of its own, and a node of it in a process of its own."""

import asyncio
import os
import random
import socket
import sys
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

__all__ = ["INTERFACES", "URI", "Peer", "free_domain", "peer", "until"]

URI = (
    "<CycloneDDS><Domain>"
    '<General><Interfaces><NetworkInterface name="lo"/></Interfaces><AllowMulticast>false</AllowMulticast></General>'
    "<Discovery><ParticipantIndex>auto</ParticipantIndex><LeaseDuration>1s</LeaseDuration>"
    '<Peers><Peer Address="localhost"/></Peers></Discovery>'
    "</Domain></CycloneDDS>"
)
"""Nothing leaves this machine, and a process that was killed is missed after a second."""

INTERFACES = Path(__file__).parent / "interfaces"
"""Definitions that robots have and this distribution does not."""

_ROOT = Path(__file__).parents[2]


def free_domain() -> int:
    """Return a domain that no other test uses: below the ports that this machine gives to others."""
    while True:
        domain = random.randint(1, 99)
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as trial:
            try:
                trial.bind(("127.0.0.1", 7400 + 250 * domain + 10))
            except OSError:
                continue
        return domain


async def until(holds: object, what: str, seconds: float = 20.0) -> None:
    """Wait until `holds()` does; events of another process cannot be awaited.

    Raises:
        TimeoutError: it does not.
    """
    assert callable(holds)
    try:
        async with asyncio.timeout(seconds):
            while not holds():  # noqa: ASYNC110 - what another process does has no event here
                await asyncio.sleep(0.01)
    except TimeoutError:
        raise TimeoutError(f"{what} within {seconds:g} s") from None


class Peer:
    """The process of a node."""

    def __init__(self, process: asyncio.subprocess.Process) -> None:
        self.process = process

    async def said(self, line: str) -> None:
        """Wait for a line that it prints."""
        assert self.process.stdout is not None
        async with asyncio.timeout(30):
            while (said := (await self.process.stdout.readline()).decode().rstrip()) != line:
                if not said and self.process.stdout.at_eof():
                    raise RuntimeError(f"the node has ended before it said {line!r}")

    async def kill(self) -> None:
        """Kill it, as if its machine lost power."""
        self.process.kill()
        await self.process.wait()


@asynccontextmanager
async def peer(module: str, *arguments: str) -> AsyncIterator[Peer]:
    """Run a node of ours as a process while the block does: `python -m module arguments`."""
    process = await asyncio.create_subprocess_exec(
        *(sys.executable, "-m", module, *arguments),
        cwd=_ROOT,
        stdout=asyncio.subprocess.PIPE,
        env={**os.environ, "CYCLONEDDS_URI": URI},
    )
    try:
        yield Peer(process)
    finally:
        if process.returncode is None:
            process.kill()
        await process.communicate()
