"""The vendor's daemon of a Reachy Mini in a network of its own: it announces itself to all others."""

import asyncio
import os
import subprocess
import time
import urllib.request
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Self

from tests.support.namespaces import Namespace, namespace

__all__ = ["PROGRAM", "VendorDaemon"]

PROGRAM = Path(__file__).parents[2] / ".venv-reachy/bin/reachy-mini-daemon"
"""Where `make robots` installs it."""

_READY = 90.0
"""Seconds that it may take on a busy machine."""


class VendorDaemon:
    """The daemon, with a robot of its own that is a mock-up, and without media."""

    def __init__(self, network: Namespace, folder: Path) -> None:
        # Installations without robots have none of its modules, and read this file all the same.
        from openrois_robots.reachy.daemon.address import Address

        self.address: Address = Address(network.there)
        self.log = folder / "daemon.log"
        self._network = network
        self._folder = folder
        self._process: subprocess.Popen[bytes] | None = None

    @classmethod
    @contextmanager
    def running(cls, folder: Path) -> Iterator[Self]:
        """Run it; what it writes stays in a folder."""
        with namespace() as network:
            daemon = cls(network, folder)
            daemon.start()
            try:
                yield daemon
            finally:
                daemon.end()

    def start(self) -> None:
        """Start it, and wait until it is ready."""
        options = ("--mockup-sim", "--no-media", "--no-wake-up-on-start", "--no-goto-sleep-on-stop")
        with self.log.open("ab") as log:
            self._process = subprocess.Popen(
                [*self._network.prefix, str(PROGRAM), *options, "--fastapi-host", self.address.host],
                env={**os.environ, "HF_HUB_OFFLINE": "1", "HOME": str(self._folder)},
                stdout=log,
                stderr=log,
            )
        late = time.monotonic() + _READY
        while not self._is_ready():
            assert time.monotonic() < late, self.log.read_text(encoding="utf-8")
            time.sleep(0.2)

    def end(self) -> None:
        """Let it die."""
        if self._process is not None:
            self._process.kill()
            self._process.wait()

    async def kill(self) -> None:
        """Let it die."""
        await asyncio.to_thread(self.end)

    async def start_again(self) -> None:
        """Start it at the same address, and wait until it is ready."""
        await asyncio.to_thread(self.start)

    def _is_ready(self) -> bool:
        assert self._process is not None
        assert self._process.poll() is None, self.log.read_text(encoding="utf-8")
        try:
            with urllib.request.urlopen(f"{self.address.url('http')}/api/daemon/status", timeout=1) as answer:
                return b'"running"' in answer.read()
        except OSError:
            return False
