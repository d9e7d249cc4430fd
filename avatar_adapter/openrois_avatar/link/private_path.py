"""A path for a socket that only this user can reach, and the removal of those that killed adapters left."""

from __future__ import annotations

import os
import socket
import stat
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Final

SETTLED: Final = 60.0
"""Seconds after which a directory with a socket that refuses connections is abandoned, and not just being set up."""
_PREFIX: Final = "openrois-"
_NAME: Final = "engine"


@contextmanager
def private_path() -> Iterator[str]:
    """Yield a path for a Unix socket in a directory of its own (mode 0700), which is removed afterwards."""
    remove_abandoned()
    with tempfile.TemporaryDirectory(prefix=f"{_PREFIX}{os.getpid()}-", ignore_cleanup_errors=True) as directory:
        yield str(Path(directory, _NAME))


def remove_abandoned() -> None:
    """Remove the directories that killed adapters of this user have left."""
    for directory in Path(tempfile.gettempdir()).glob(f"{_PREFIX}*"):
        if _is_abandoned(directory):
            with suppress(OSError):  # another process may be cleaning up, too
                (directory / _NAME).unlink()
                directory.rmdir()


def clear(path: str) -> None:
    """Remove a socket that a killed adapter left at this path; nothing else is touched."""
    if is_deserted(path):
        with suppress(OSError):
            Path(path).unlink()


def is_deserted(path: str) -> bool:
    """Return whether there is a socket of this user without a listener."""
    try:
        info = Path(path).lstat()
        if not stat.S_ISSOCK(info.st_mode) or info.st_uid != os.getuid():
            return False
        with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as probe:
            probe.setblocking(False)
            probe.connect(path)
    except ConnectionRefusedError:
        return True
    except OSError:
        pass  # no file, or a busy socket
    return False


def _is_abandoned(directory: Path) -> bool:
    """Return whether this is a directory of this user with a socket without a listener, and not just being set up.

    A process of another container may share the directory and be unknown here; it needs no time to listen.
    """
    try:
        info = directory.lstat()
    except OSError:
        return False  # another process has cleaned up
    settled = time.time() - info.st_mtime >= SETTLED or not _runs(directory.name)
    return stat.S_ISDIR(info.st_mode) and info.st_uid == os.getuid() and settled and is_deserted(str(directory / _NAME))


def _runs(name: str) -> bool:
    """Return whether the process that a directory is named after may be running."""
    owner = name.removeprefix(_PREFIX).partition("-")[0]
    return not owner.isdecimal() or Path("/proc", owner).exists() or not Path("/proc/self").exists()
