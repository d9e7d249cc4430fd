"""Telling the supervisor that a process is ready, lives, and stops: systemd's protocol, where it is spoken."""

import asyncio
import logging
import socket
from collections.abc import Awaitable, Callable, Mapping

__all__ = ["Supervisor"]

_log = logging.getLogger(__name__)


class Supervisor:
    """Whoever started the process and watches over it; without one nothing is told.

    Args:
        environment: names its socket (`NOTIFY_SOCKET`), and how often it wants to hear (`WATCHDOG_USEC`).
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

    def tell(self, state: str) -> None:
        """Send `READY=1`, `STOPPING=1` or the like; one that is gone is no fault of ours."""
        if not self._address:
            return
        try:
            with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM | socket.SOCK_CLOEXEC | socket.SOCK_NONBLOCK) as to:
                to.sendto(state.encode(), self._address)
        except OSError as error:
            _log.debug("the supervisor does not hear %s: %s", state, error)

    async def watch(self) -> None:
        """Tell it for ever that the event loop turns; when that stays away, it starts the process again."""
        while self._address and self._period:
            self.tell("WATCHDOG=1")
            await self._sleep(self._period)
