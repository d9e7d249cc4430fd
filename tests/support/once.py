"""What is made once for all processes of a run."""

import os
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

__all__ = ["once", "shared_folder"]


def shared_folder(factory: pytest.TempPathFactory, name: str) -> Path:
    """Return a folder that all workers of a run have in common."""
    own = factory.getbasetemp()
    shared = (own.parent if "PYTEST_XDIST_WORKER" in os.environ else own) / name
    shared.mkdir(exist_ok=True)
    return shared


def once(made: Path, make: Callable[[Path], object]) -> Path:
    """Make a file or folder where it is not there yet, also where several processes want it at the same time.

    Each process is told by `make` what is wrong: what a failed one has left behind is removed before the next one.
    """
    import fcntl  # Only here: modules that import this one are read also where there is none.

    finished = made.with_name(f"{made.name}.made")
    with made.with_name(f"{made.name}.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not finished.exists():
            if made.is_dir():
                shutil.rmtree(made)
            made.unlink(missing_ok=True)
            make(made)
            finished.touch()
    return made
