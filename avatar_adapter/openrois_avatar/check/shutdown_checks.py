"""Checks of an engine's end: when the adapter disconnects, and on `quit`."""

from collections.abc import AsyncIterator
from typing import Final, Protocol

from openrois_avatar.check.command_checks import Patience
from openrois_avatar.check.connection import CheckedConnection
from openrois_avatar.check.finding import Finding, failed, judged, not_tried, passed
from openrois_avatar.link.messages import Quit

__all__ = ["CheckedEngine", "check_shutdown"]

END: Final = "From the greeting to the end"
YOURS: Final = "An engine of your own"


class CheckedEngine(Protocol):
    """The engine under test, which may connect again."""

    @property
    def status(self) -> int | None:
        """The exit status of its process, None while that runs, and where it was not started by the check."""

    @property
    def was_started(self) -> bool:
        """Whether the check has started its process."""

    async def ended(self, seconds: float) -> bool:
        """Wait until its process has ended, `seconds` at most; return whether it has."""

    async def again(self, seconds: float) -> CheckedConnection | None:
        """Return its next connection after HELLO and WELCOME; None if none comes in time, or its process ends."""

    async def anew(self) -> CheckedConnection | None:
        """Start its process again, and return the new connection."""


async def check_shutdown(
    connection: CheckedConnection, engine: CheckedEngine, patience: Patience
) -> AsyncIterator[Finding]:
    """End the connection as an adapter that disconnects, check the engine's reaction, and send it `quit`."""
    connection.hang_up("the adapter ends")
    back = await engine.again(patience.come_back)
    yield _gone(back, engine, patience)
    if back is None and engine.status is not None:
        back = await engine.anew()
    if back is None:
        yield not_tried("quit", "the engine does not connect again", END)
    else:
        yield await _quit(back, engine, patience)
        back.hang_up("the check is over")


def _gone(back: CheckedConnection | None, engine: CheckedEngine, patience: Patience) -> Finding:
    if back is not None:
        return passed("adapter gone", "the engine connected again, and greeted anew", YOURS)
    if not engine.was_started:
        told = f"the engine did not connect again within {patience.come_back:g} s: it has ended, or stays away"
        return passed("adapter gone", told, YOURS)
    if engine.status is None:
        told = f"the engine neither ended nor connected again within {patience.come_back:g} s"
        return failed("adapter gone", told, YOURS)
    return passed("adapter gone", f"the engine ended, with status {engine.status}", YOURS)


async def _quit(connection: CheckedConnection, engine: CheckedEngine, patience: Patience) -> Finding:
    connection.send_command(Quit())
    await connection.until(connection.is_over, patience.answer)
    if not connection.is_over():
        return failed("quit", f"the engine is still connected {patience.answer:g} s after `quit`", END)
    if not engine.was_started:
        return passed("quit", "the engine closed its connection", END)
    if not await engine.ended(patience.end):
        return failed("quit", f"the process still runs {patience.end:g} s after `quit`", END)
    faults = [f"the process ended with status {engine.status}, not 0"] if engine.status else []
    return judged("quit", faults, "the engine ended with status 0", END)
