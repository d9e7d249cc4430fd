"""A PostgreSQL server of the tests' own: it is killed, stopped, cut off and set back as they like."""

import os
import select
import shutil
import signal
import subprocess
import tempfile
from collections.abc import AsyncIterator, Iterator, Mapping
from contextlib import asynccontextmanager, contextmanager, suppress
from pathlib import Path
from typing import Any, Final

from tests.support.canary import CANARY
from tests.support.clocks import environment

__all__ = ["PASSWORD", "Server", "programs"]

PASSWORD: Final = f"{CANARY}-of-the-store"
_SETTINGS: Final = {
    # Nothing of a test outlives the machine, and a server that is killed loses nothing that the system has.
    "fsync": "off",
    "full_page_writes": "off",
    "listen_addresses": "",
    "max_connections": "60",
    "shared_buffers": "16MB",
    "dynamic_shared_memory_type": "mmap",
    "autovacuum": "off",
    "logging_collector": "off",
}


def programs() -> Path | None:
    """Return the folder with the programs of the newest PostgreSQL that is installed; None for none."""
    found = sorted(Path("/usr/lib/postgresql").glob("*/bin/postgres"), key=lambda path: float(path.parts[-3]))
    if found:
        return found[-1].parent
    on_path = shutil.which("postgres")
    return Path(on_path).resolve().parent if on_path else None


class Server:
    """A server with a folder of data and a Unix socket, and with a user `openrois` that has a password.

    Attributes:
        url: of its database.
        socket: its path.
        password_file: holds the password.
        settings: a server that starts has these.
        ahead: seconds by which the clock of a server that starts is ahead of this machine's.
    """

    def __init__(self, folder: Path, programs: Path) -> None:
        self._folder = folder
        self._programs = programs
        self._process: subprocess.Popen[Any] | None = None
        self.settings = {**_SETTINGS, "unix_socket_directories": str(folder)}
        self.url = f"postgresql://openrois@/postgres?host={folder}"
        self.socket = f"{folder}/.s.PGSQL.5432"
        self.password_file = folder / "password"
        self.data = folder / "data"
        self.ahead = 0.0

    @classmethod
    @contextmanager
    def running(cls, programs: Path) -> "Iterator[Server]":
        """Run a server with an empty database."""
        # A socket's path is short, and another user than root can go there.
        with tempfile.TemporaryDirectory(prefix="or-pg-") as folder:
            server = cls(Path(folder), programs)
            server._make()
            server.start()
            try:
                yield server
            finally:
                server.kill()

    def _make(self) -> None:
        self.password_file.write_text(f"{PASSWORD}\n")
        self.password_file.chmod(0o600)
        self.own(self._folder)
        self.own(self.password_file)
        self._run("initdb", "-D", self.data, "-U", "openrois", f"--pwfile={self.password_file}", *_PLAIN)

    def start(self) -> None:
        """Start the server, and return when it takes connections."""
        (self.data / "postmaster.pid").unlink(missing_ok=True)
        options = [
            f"-c{name}={value}"
            for name, value in {**self.settings, "unix_socket_directories": str(self._folder)}.items()
        ]
        with (self._folder / "log").open("ab") as log:
            words = [str(self._programs / "postgres"), "-D", str(self.data), *options]
            env = {**os.environ, **environment(self.ahead)} if self.ahead else None
            process = subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=log, env=env, **_as_another())
        self._process = process
        status = self.data / "postmaster.pid"
        while not (status.exists() and "ready" in status.read_text()):
            if process.poll() is not None:
                raise RuntimeError(self.log())
            os.sched_yield()

    @asynccontextmanager
    async def admin(self) -> AsyncIterator[Any]:
        """Connect beside what is tested."""
        import asyncpg

        connection = await asyncpg.connect(self.url, password=PASSWORD)
        try:
            yield connection
        finally:
            await connection.close(timeout=5)

    def set_clock(self, ahead: float) -> None:
        """Start the server anew with a clock that is so many seconds ahead."""
        self.kill()
        self.ahead = ahead
        self.start()

    @contextmanager
    def configured(self, **settings: str) -> Iterator[None]:
        """Restart the server with other settings for the block."""
        former = dict(self.settings)
        self.kill()
        self.settings.update(settings)
        self.start()
        try:
            yield
        finally:
            self.kill()
            self.settings = former
            self.start()

    def own(self, path: Path) -> None:
        """Give a file to the user that the server runs as."""
        if os.geteuid() == 0:
            shutil.chown(path, *_user())

    def log(self) -> str:
        """Return what the server has said."""
        return (self._folder / "log").read_text(errors="replace")

    def kill(self) -> None:
        """Kill every process of the server, and return when all are gone: another one does not start before."""
        if self._process is not None:
            ends = [fd for each in self._pids() if (fd := _watch(each)) is not None]
            self._signal(signal.SIGKILL)
            for each in ends:
                select.select([each], [], [], 20.0)
                os.close(each)
            self._process.wait()
            self._process = None

    def stop(self) -> None:
        """Let every process of the server stand still."""
        self._signal(signal.SIGSTOP)

    def go_on(self) -> None:
        """Let them go on."""
        self._signal(signal.SIGCONT)

    def restart_from(self, copy: Path) -> None:
        """Start the server with a former copy of its data."""
        self.kill()
        shutil.rmtree(self.data)
        self.copy(copy, self.data)
        self.start()

    def copy(self, origin: Path, target: Path) -> None:
        """Copy a folder of data with its owner and rights."""
        subprocess.run(["cp", "-a", origin, target], check=True)

    def _pids(self) -> list[int]:
        assert self._process is not None
        # Backends have sessions of their own, and belong to the postmaster.
        children = Path(f"/proc/{self._process.pid}/task/{self._process.pid}/children").read_text().split()
        return [self._process.pid, *map(int, children)]

    def _signal(self, number: int) -> None:
        for each in self._pids():
            with suppress(ProcessLookupError):
                os.kill(each, number)

    def _run(self, program: str, *arguments: str | Path) -> None:
        subprocess.run([self._programs / program, *arguments], check=True, stdout=subprocess.DEVNULL, **_as_another())


_PLAIN: Final = ("--auth=scram-sha-256", "--no-sync", "--encoding=UTF8", "--locale=C")


def _user() -> tuple[str, str]:
    """Return the user and group that a server runs as where tests are root's: it refuses to be root."""
    return ("postgres", "postgres") if Path("/var/lib/postgresql").exists() else ("nobody", "nogroup")


def _as_another() -> Mapping[str, Any]:
    return dict(zip(("user", "group"), _user(), strict=True), extra_groups=()) if os.geteuid() == 0 else {}


def _watch(pid: int) -> int | None:
    """Return a descriptor that is readable when a process is gone; None where it is gone already."""
    with suppress(ProcessLookupError):
        return os.pidfd_open(pid)
    return None
