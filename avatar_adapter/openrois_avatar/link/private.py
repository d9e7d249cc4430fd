"""A socket's path that only this user can reach, and the removal of those that killed adapters left behind."""

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
"""Seconds after which a directory whose socket refuses connections is abandoned and not just being set up."""
_PREFIX: Final = "openrois-"
_NAME: Final = "engine"


@contextmanager
def private_path() -> Iterator[str]:
    """A path for a Unix socket in a directory of its own (mode 0700), which is removed afterwards."""
    with tempfile.TemporaryDirectory(prefix=_PREFIX, ignore_cleanup_errors=True) as directory:
        for other in Path(directory).parent.glob(f"{_PREFIX}*"):
            if _is_abandoned(other):
                with suppress(OSError):  # somebody else may be cleaning up too
                    (other / _NAME).unlink()
                    other.rmdir()
        yield str(Path(directory, _NAME))


def _is_abandoned(directory: Path) -> bool:
    """Whether this is a directory of ours, some time old, in which nobody listens any more."""
    try:
        info = directory.lstat()
        if not stat.S_ISDIR(info.st_mode) or info.st_uid != os.getuid() or time.time() - info.st_mtime < SETTLED:
            return False
        with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as probe:
            probe.setblocking(False)
            probe.connect(str(directory / _NAME))
    except ConnectionRefusedError:
        return True
    except OSError:
        pass  # no socket there, or one that is busy
    return False
