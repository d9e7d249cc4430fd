"""Tries how an engine ends: when the adapter goes away, and when it is told to quit."""

from collections.abc import AsyncIterator
from typing import Final, Protocol

from openrois_avatar.check.acting import Patience
from openrois_avatar.check.finding import Finding, failed, judged, not_tried, passed
from openrois_avatar.check.line import Line
from openrois_avatar.link.messages import Quit

__all__ = ["Visitor", "ending"]

END: Final = "From the greeting to the end"
YOURS: Final = "An engine of your own"


class Visitor(Protocol):
    """The engine under test, which may come again."""

    @property
    def status(self) -> int | None:
        """The exit status of its process, None while that runs, and where it was not started by the check."""

    @property
    def was_started(self) -> bool:
        """Whether the check has started it."""

    async def ended(self, seconds: float) -> bool:
        """Wait so long at most until its process has ended; whether it has."""

    async def again(self, seconds: float) -> Line | None:
        """Its next connection, greeted and welcome; None if none comes in time, or its process ends before."""

    async def anew(self) -> Line | None:
        """The connection of a new process of it."""


async def ending(line: Line, visitor: Visitor, patience: Patience) -> AsyncIterator[Finding]:
    """End the connection as an adapter that goes away, see what the engine does, and tell it to quit."""
    line.hang_up("the adapter ends")
    back = await visitor.again(patience.come_back)
    yield _gone(back, visitor, patience)
    if back is None and visitor.status is not None:
        back = await visitor.anew()
    if back is None:
        yield not_tried("quit", "the engine does not connect again", END)
    else:
        yield await _quit(back, visitor, patience)
        back.hang_up("the check is over")


def _gone(back: Line | None, visitor: Visitor, patience: Patience) -> Finding:
    if back is not None:
        return passed("adapter gone", "the engine connected again, and greeted anew", YOURS)
    if not visitor.was_started:
        told = f"the engine did not connect again within {patience.come_back:g} s: it has ended, or stays away"
        return passed("adapter gone", told, YOURS)
    if visitor.status is None:
        told = f"the engine neither ended nor connected again within {patience.come_back:g} s"
        return failed("adapter gone", told, YOURS)
    return passed("adapter gone", f"the engine ended, with status {visitor.status}", YOURS)


async def _quit(line: Line, visitor: Visitor, patience: Patience) -> Finding:
    line.tell(Quit())
    await line.until(line.is_over, patience.answer)
    if not line.is_over():
        return failed("quit", f"the engine is still connected {patience.answer:g} s after `quit`", END)
    if not visitor.was_started:
        return passed("quit", "the engine closed its connection", END)
    if not await visitor.ended(patience.end):
        return failed("quit", f"the process still runs {patience.end:g} s after `quit`", END)
    faults = [f"the process ended with status {visitor.status}, not 0"] if visitor.status else []
    return judged("quit", faults, "the engine ended with status 0", END)
