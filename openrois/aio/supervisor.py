"""Notifies the supervisor of a process that it is ready, alive or stopping, by systemd's protocol."""

import asyncio
import logging
import socket
from collections.abc import Awaitable, Callable, Mapping

__all__ = ["Supervisor"]

_log = logging.getLogger(__name__)


class Supervisor:
    """The supervisor that started the process; without one nothing is sent.

    Args:
        environment: names its socket (`NOTIFY_SOCKET`), and how often it wants a sign of life (`WATCHDOG_USEC`).
        sleep: waits for some seconds.
    """

    def __init__(
        self, environment: Mapping[str, str], sleep: Callable[[float], Awaitable[None]] = asyncio.sleep
    ) -> None:
        address = environment.get("NOTIFY_SOCKET", "")
        # A name that begins with @ is one of the abstract namespace, where a NUL stands for it.
        self._address = "\0" + address[1:] if address.startswith("@") else address
        microseconds = environment.get("WATCHDOG_USEC", "")
        self._period = int(microseconds) / 2e6 if microseconds.isdecimal() else 0.0
        self._sleep = sleep

    def notify_state(self, state: str) -> None:
        """Send `READY=1`, `STOPPING=1` or the like; a supervisor that is gone is ignored."""
        if not self._address:
            return
        try:
            with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM | socket.SOCK_CLOEXEC | socket.SOCK_NONBLOCK) as to:
                to.sendto(state.encode(), self._address)
        except OSError as error:
            _log.debug("the supervisor does not hear %s: %s", state, error)

    async def watch(self) -> None:
        """Send for ever that the event loop turns; when that stays away, the supervisor restarts the process."""
        while self._address and self._period:
            self.notify_state("WATCHDOG=1")
            await self._sleep(self._period)
