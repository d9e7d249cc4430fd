"""Kills a program that hangs: one that sends no sign of life any more, as service managers ask for them."""

import asyncio
import logging
import socket
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Final

from openrois_demo.waiting import Sleep, happens
from openrois_demo.watchdog import Restartable

__all__ = ["LifeSigns"]

_log = logging.getLogger(__name__)

SILENCE: Final = 20.0
"""Seconds without a sign of life behind which a program hangs; it sends one in half of that."""


class LifeSigns(asyncio.DatagramProtocol):
    """The signs of life of a program, which sends them by systemd's protocol.

    Args:
        path: of the socket that gets them; in a folder that this user alone can reach.
        sleep: waits for some seconds; all waits use it.

    Attributes:
        environment: tells the program of it.
    """

    def __init__(self, path: Path, sleep: Sleep = asyncio.sleep) -> None:
        self.environment: Mapping[str, str] = MappingProxyType(
            {"NOTIFY_SOCKET": str(path), "WATCHDOG_USEC": f"{SILENCE * 1e6:.0f}"}
        )
        self._path = path
        self._sleep = sleep
        self._heard = asyncio.Event()

    def datagram_received(self, _data: bytes, _sender: object) -> None:
        """Take a sign of life: whatever comes is one."""
        self._heard.set()

    async def watch(self, program: Restartable) -> None:
        """Kill the program whenever it is silent for too long, until cancelled; return where no sign can come."""
        try:
            transport, _ = await asyncio.get_running_loop().create_datagram_endpoint(
                lambda: self, local_addr=str(self._path), family=socket.AF_UNIX
            )
        except OSError as error:
            # The path of a socket has 107 bytes at most, whatever folder is for temporary files.
            _log.warning(
                "a %s that hangs is not noticed: no socket can be made at %s (%s); set TMPDIR to a short path",
                program.name,
                self._path,
                error.strerror or error,
            )
            return
        try:
            while True:
                # One that begins is silent for as long as that takes.
                await self._heard.wait()
                await self._end_when_silent(program)
        finally:
            transport.close()

    async def _end_when_silent(self, program: Restartable) -> None:
        runs = program.runs
        while self._heard.is_set():
            runs = program.runs
            self._heard.clear()
            await happens(self._heard, SILENCE, self._sleep)
        if program.runs == runs:
            _log.warning("%s runs but does not answer: it is killed, and started again", program.name)
            program.kill()
