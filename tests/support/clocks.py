"""Processes with another wall clock than this machine's, by libfaketime; monotonic clocks stay as they are."""

import os
import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Final

__all__ = ["HOUR", "environment", "library", "program_at", "shared_memory_removed"]

HOUR: Final = 3600.0

_SHARED: Final = re.compile(r"(?:sem\.)?faketime_(?:shm|sem)_(\d+)")


def library() -> Path | None:
    """Return libfaketime for programs with threads; None where it is not installed."""
    return next(iter(sorted(Path("/usr/lib").glob("*/faketime/libfaketimeMT.so.1"))), None)


def environment(ahead: float) -> Mapping[str, str]:
    """Return what the environment of a process has more whose wall clock is so many seconds ahead."""
    return {
        "LD_PRELOAD": str(library()),
        "FAKETIME": f"{ahead:+.0f}",
        "FAKETIME_DONT_FAKE_MONOTONIC": "1",
        # The times of files are the system's.
        "NO_FAKE_STAT": "1",
    }


def program_at(ahead: float, *words: str) -> tuple[str, ...]:
    """Return the words by which a program runs with a wall clock that is so many seconds ahead."""
    return "env", *(f"{name}={value}" for name, value in environment(ahead).items()), *words


@contextmanager
def shared_memory_removed() -> Iterator[None]:
    """Remove what processes leave in the end that were killed: the library shares its clock with their children."""
    try:
        yield
    finally:
        for path in Path("/dev/shm").glob("*faketime_*"):
            found = _SHARED.fullmatch(path.name)
            if found and not _is_running(int(found[1])):
                path.unlink(missing_ok=True)


def _is_running(pid: int) -> bool:
    with suppress(ProcessLookupError):
        os.kill(pid, 0)
        return True
    return False
