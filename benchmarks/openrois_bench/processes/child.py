"""Processes of a bench of the gateway, and their use of resources by the system's counters."""

import asyncio
import os
import signal
import sys
from collections.abc import AsyncIterator, Mapping
from contextlib import asynccontextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from openrois_bench.errors import BenchFailed, within

__all__ = ["Child", "child", "cpu_of", "descendants", "own_cpu"]

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
        return cpu_of(self.pid)

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
    return cpu_of(os.getpid())


def cpu_of(*pids: int) -> float:
    """Return the processor seconds that processes have used, all together."""
    # The program's name stands in brackets and may hold anything; utime and stime are the 12th and 13th field after it.
    told = (Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split() for pid in pids)
    return sum(int(fields[11]) + int(fields[12]) for fields in told) / _TICKS


def descendants(pid: int) -> list[int]:
    """Return the processes that a process has started, and those that these have."""
    tasks = Path(f"/proc/{pid}/task").glob("*/children")
    children = [int(number) for task in tasks for number in task.read_text().split()]
    return [each for number in children for each in (number, *descendants(number))]


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
