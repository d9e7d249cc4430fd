"""The processes that take part in a bench of the gateway, and what the system says they have used."""

import asyncio
import os
import signal
import sys
from collections.abc import AsyncIterator, Mapping
from contextlib import asynccontextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from openrois.bench.errors import BenchFailed, within

__all__ = ["Child", "child", "own_cpu"]

PATIENCE: Final = 20.0
"""Seconds that a process has to say that it is ready, and to end."""

_TICKS: Final = os.sysconf("SC_CLK_TCK")
_MEBIBYTE: Final = 1024


@dataclass(frozen=True, slots=True)
class Child:
    """A process of a bench.

    Attributes:
        pid: its number.
        said: its first line, which says where it can be reached.
    """

    pid: int
    said: str

    def cpu(self) -> float:
        """Return the processor seconds that it has used, its threads and the kernel's work for it included."""
        return _cpu(Path(f"/proc/{self.pid}/stat"))

    def memory(self) -> float:
        """Return the MiB that it has in memory."""
        for line in Path(f"/proc/{self.pid}/status").read_text().splitlines():
            name, _, value = line.partition(":")
            if name == "VmRSS":
                return int(value.split()[0]) / _MEBIBYTE
        raise BenchFailed(f"the system does not tell the memory of process {self.pid}")

    def descriptors(self) -> int:
        """Return how many files and connections it has open."""
        return len(list(Path(f"/proc/{self.pid}/fd").iterdir()))


def own_cpu() -> float:
    """Return the processor seconds that this process has used."""
    return _cpu(Path("/proc/self/stat"))


def _cpu(stat: Path) -> float:
    # The program's name stands in brackets and may hold anything; utime and stime are the 12th and 13th field after it.
    fields = stat.read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / _TICKS


@asynccontextmanager
async def child(*arguments: str, environment: Mapping[str, str] | None = None) -> AsyncIterator[Child]:
    """Run `python ARGUMENTS` until the block ends, and yield once it has said its first line.

    Raises:
        BenchFailed: it ended, or said nothing in time.
    """
    what = " ".join(arguments[:4])
    process = await asyncio.create_subprocess_exec(
        sys.executable,
        *arguments,
        stdin=asyncio.subprocess.DEVNULL,
        stdout=asyncio.subprocess.PIPE,
        env={**os.environ, **(environment or {})},
    )
    try:
        assert process.stdout is not None
        async with within(PATIENCE, f"the start of {what}"):
            said = (await process.stdout.readline()).decode().strip()
        if not said:
            raise BenchFailed(f"{what} ended with exit status {await process.wait()}")
        yield Child(process.pid, said)
    finally:
        if process.returncode is None:
            process.send_signal(signal.SIGTERM)
        try:
            async with asyncio.timeout(PATIENCE):
                await process.wait()
        except TimeoutError:
            process.kill()
            await process.wait()
