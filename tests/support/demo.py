"""`openrois demo` as users run it: a process of its own, on a free port."""

import itertools
import os
import secrets
import select
import signal
import socket
import subprocess
import sys
import threading
import time
from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import IO, Final, Self

import psutil
import pytest
from aiohttp import ClientSession

from openrois.client import Client
from openrois.errors import Unsupported

_ROOT: Final = Path(__file__).parents[2]
PATIENCE: Final = 90.0
"""Seconds that programs may take on a busy machine to begin, to say what they have to say, and to be gone."""
_END: Final = 10.0

_LANES: Final = 8
_LANE: Final = int(os.environ.get("PYTEST_XDIST_WORKER", "gw0")[2:]) % _LANES
"""Workers of one run choose among different ports: one may be chosen long before a program listens there."""
_CHOSEN: Final = deque[int](maxlen=256)


def free_port() -> int:
    """Return a TCP port of the loopback interface that is free and outside of the range of ephemeral ports.

    Debian's ephemeral ports begin at 32768. A restarted program can use the port again.
    """
    while True:
        # Tests of other runs must not try the same ones, however they seed `random`.
        port = 20_000 + secrets.randbelow(12_000 // _LANES) * _LANES + _LANE
        if port in _CHOSEN:
            continue
        with socket.socket() as probe, suppress(OSError):
            probe.bind(("127.0.0.1", port))
            _CHOSEN.append(port)
            return port


def start(*arguments: str, log: IO[str] | int = subprocess.PIPE) -> subprocess.Popen[str]:
    """Start `openrois` with `arguments` in a process group of its own, as a terminal does.

    It does not survive this process, nor the thread that calls this.
    """
    return subprocess.Popen(
        [sys.executable, "-m", "openrois_body.processes.launch", str(os.getpid()), "openrois.cli", *arguments],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=log,
        text=True,
        start_new_session=True,
        cwd=_ROOT,
    )


_OPTIONS: Final[Mapping[str, Sequence[str]]] = {
    "synthetic": ("--stamp",),
    "panda3d": ("--size", "640x360"),
    "puppet": ("--size", "640x360", "--visitor"),
}
"""What tests ask of a game engine: pictures of one size, whatever the machine carries."""


class Demo:
    """A demo that has printed its `ready` line.

    Attributes:
        process: it.
        port: where its gateway listens.
        ready: the line that said so.
    """

    def __init__(self, process: subprocess.Popen[str], port: int, ready: str, log: Path) -> None:
        self.process = process
        self.port = port
        self.ready = ready
        self._log = log

    @property
    def url(self) -> str:
        """Where applications connect."""
        return f"ws://127.0.0.1:{self.port}/"

    @property
    def page(self) -> str:
        """Where a browser finds the page."""
        return f"http://127.0.0.1:{self.port}/"

    def program(self, name: str) -> psutil.Process:
        """The process that runs the sub-command `name` now."""
        return next(child for child in self.tree() if name in child.cmdline())

    def tree(self) -> list[psutil.Process]:
        """All processes that it started and that run now."""
        found: list[psutil.Process] = psutil.Process(self.process.pid).children(recursive=True)
        return found

    def log(self) -> str:
        """What it and its programs wrote to standard error so far."""
        return self._log.read_text()

    def interrupt(self) -> int:
        """Press Ctrl-C; returns the exit status."""
        os.killpg(self.process.pid, signal.SIGINT)
        return self.process.wait(_END)


@contextmanager
def running_demo(folder: Path, engine: str = "synthetic", more: Sequence[str] = ()) -> Iterator[Demo]:
    """Run a demo for as long as the block does, with more options where they are given; its log goes into `folder`.

    A test picture is stamped.

    Raises:
        AssertionError: it did not start, or left a process behind.
    """
    path, port = folder / "demo.log", free_port()
    more = (*_OPTIONS.get(engine, ()), *more)
    with path.open("w") as log:
        process = start("demo", "--engine", engine, "--port", str(port), *more, log=log)
    try:
        demo = Demo(process, port, first_line(process), path)
        assert demo.ready, path.read_text()
        tree = demo.tree()
        yield demo
        tree += demo.tree() if process.poll() is None else []
    finally:
        end(process)
    assert not psutil.wait_procs(tree, timeout=PATIENCE)[1]


class Demos:
    """Demos that tests share. One runs at a time, as a game engine draws also without a viewer.

    Args:
        folders: where their logs go.

    Attributes:
        running: the one that runs now.
    """

    def __init__(self, folders: pytest.TempPathFactory) -> None:
        self.running: Demo | None = None
        self._folders = folders
        self._stack = ExitStack()
        self._engine = ""

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._stack.close()

    @contextmanager
    def watched(self, engine: str) -> Iterator[Demo]:
        """The demo with this game engine; if another one runs, that is ended.

        Raises:
            AssertionError: something went wrong in it during the block, and only its log says so.
        """
        if self.running is None or self._engine != engine:
            self._stack.close()
            folder = self._folders.mktemp(engine)
            self.running, self._engine = self._stack.enter_context(running_demo(folder, engine)), engine
        before = len(self.running.log())
        yield self.running
        log = self.running.log()[before:]
        assert "Traceback" not in log, log


async def hand_back(demo: Demo) -> None:
    """Hand the bodies of a demo that a person has stopped back to programs, as a person on its page does."""
    if demo.process.poll() is not None:
        return
    async with ClientSession() as session, session.get(f"{demo.page}page-token") as answer:
        token = (await answer.json())["token"]
    async with Client(demo.url, token=token) as client:
        for body in await client.bodies():
            with suppress(Unsupported):  # nothing acts there: it cannot be stopped
                await client.control.release_stop(body.engine_id)


def first_line(process: subprocess.Popen[str]) -> str:
    """The first line on its standard output, without its end; empty if it ends without one."""
    assert process.stdout is not None
    readable, _, _ = select.select([process.stdout], [], [], PATIENCE)
    return process.stdout.readline().rstrip("\n") if readable else ""


def end(process: subprocess.Popen[str]) -> None:
    """End a process politely or else by force."""
    if process.poll() is None:
        process.terminate()
        try:
            process.wait(_END)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
    for stream in (process.stdout, process.stderr):
        if stream is not None:
            stream.close()


class Watcher:
    """A viewer in a process of its own, and the pictures that it shows.

    Attributes:
        process: it.
        arrivals: when each picture came, in seconds of the monotonic clock that all processes share.
    """

    def __init__(self, url: str, codec: str) -> None:
        self.process = subprocess.Popen(
            [sys.executable, "-m", "tests.support.black_box", url, codec],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            text=True,
            cwd=_ROOT,
        )
        self.arrivals: list[float] = []
        self._changed = threading.Condition()
        self._reader = threading.Thread(target=self._read)
        self._reader.start()

    def _read(self) -> None:
        assert self.process.stdout is not None
        for line in self.process.stdout:
            with self._changed:
                self.arrivals.append(float(line.split()[1]))
                self._changed.notify_all()

    def wait(self, count: int, within: float = PATIENCE) -> None:
        """Wait until `count` more pictures have come.

        Raises:
            AssertionError: they did not.
        """
        with self._changed:
            wanted = len(self.arrivals) + count
            assert self._changed.wait_for(lambda: len(self.arrivals) >= wanted, within), "the viewer sees nothing"

    def longest_gap(self) -> float:
        """The longest time between two pictures so far, until now, in seconds."""
        moments = [*self.arrivals, time.monotonic()]
        return max(later - earlier for earlier, later in itertools.pairwise(moments))

    def close(self) -> None:
        """End it."""
        self.process.kill()
        self._reader.join()
        end(self.process)


@contextmanager
def watching(url: str, codec: str = "video/H264") -> Iterator[Watcher]:
    """Watch the avatar of the gateway at `url`; the block begins when pictures come."""
    watcher = Watcher(url, codec)
    try:
        watcher.wait(1)
        yield watcher
    finally:
        watcher.close()
