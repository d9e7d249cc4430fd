"""A PostgreSQL server of a measurement's own, behind a Unix socket."""

import asyncio
import getpass
import os
import shutil
import subprocess
import tempfile
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any, Final

from openrois_bench.errors import BenchFailed

__all__ = ["postgres_server"]

PATIENCE: Final = 30.0
USER: Final = "postgres"
"""The server refuses to run as root; Debian's package brings this user."""


def _programs() -> Path:
    found = sorted(Path("/usr/lib/postgresql").glob("*/bin/postgres"), key=lambda path: float(path.parts[-3]))
    on_path = shutil.which("postgres")
    if not found and on_path is None:
        raise BenchFailed("no PostgreSQL is found: install it (Debian: apt install postgresql)")
    return found[-1].parent if found else Path(str(on_path)).resolve().parent


def _run(folder: Path, *words: str | Path) -> None:
    other: dict[str, Any] = {"user": USER, "group": USER, "extra_groups": ()} if os.geteuid() == 0 else {}
    quiet = subprocess.DEVNULL
    done = subprocess.run(words, cwd=folder, stdin=quiet, stdout=quiet, stderr=quiet, timeout=PATIENCE, **other)
    if done.returncode:
        raise BenchFailed(f"{words[0]} has failed, as user {USER if other else getpass.getuser()}")


@asynccontextmanager
async def postgres_server() -> AsyncIterator[str]:
    """Run a server with its usual durability while the block runs; yields the address of its database.

    Raises:
        BenchFailed: there is none, or it does not begin.
    """
    programs = _programs()
    with tempfile.TemporaryDirectory(prefix="or-pg-") as name:
        folder = Path(name)
        if os.geteuid() == 0:
            shutil.chown(folder, USER, USER)
        data, options = folder / "data", f"-c unix_socket_directories={folder} -c listen_addresses="
        initialize = (programs / "initdb", "-D", data, "-U", "openrois", "-A", "trust", "-N")
        await asyncio.to_thread(_run, folder, *initialize)
        control = (programs / "pg_ctl", "-D", data, "-w", "-s")
        await asyncio.to_thread(_run, folder, *control, "-o", options, "-l", folder / "log", "start")
        try:
            yield f"postgresql://openrois@/postgres?host={folder}"
        finally:
            await asyncio.to_thread(_run, folder, *control, "-m", "fast", "stop")
