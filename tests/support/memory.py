"""Programs that have so much memory and no more: a control group of their own, version 1 or 2."""

import os
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Final

import pytest

__all__ = ["Limited", "limited"]

_ROOT: Final = Path("/sys/fs/cgroup")


class Limited:
    """A control group.

    Attributes:
        prefix: what a command begins with that runs in it.
    """

    def __init__(self, folder: Path, *, first_version: bool) -> None:
        self._usage = folder / ("memory.max_usage_in_bytes" if first_version else "memory.peak")
        self.prefix = ("sh", "-c", f'echo $$ > {folder}/cgroup.procs && exec "$@"', "sh")

    @property
    def peak(self) -> int:
        """Bytes that it had at most."""
        return int(self._usage.read_text())


@contextmanager
def limited(megabytes: int) -> Iterator[Limited]:
    """Make a control group; the test is skipped where that is not permitted."""
    first_version = (_ROOT / "memory").is_dir()
    folder = (_ROOT / "memory" if first_version else _ROOT) / f"openrois-{os.getpid()}"
    limit = "memory.limit_in_bytes" if first_version else "memory.max"
    try:
        folder.mkdir()
        (folder / limit).write_text(str(megabytes << 20))
    except OSError as error:
        with suppress(OSError):
            folder.rmdir()
        pytest.skip(f"a control group for memory needs root: {error.strerror}")
    try:
        yield Limited(folder, first_version=first_version)
    finally:
        for _ in range(100):
            with suppress(OSError):
                folder.rmdir()
                break
            time.sleep(0.05)
