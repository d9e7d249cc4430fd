"""The bounded, ordered outbox of one connection."""

import asyncio
import logging
from collections import deque
from collections.abc import Callable
from typing import Final

from openrois.logs import Tally

__all__ = ["Outbox", "OutboxOverflow"]

_log = logging.getLogger(__name__)

CONTROL_LIMIT: Final = 1024
"""Messages that may wait, events aside: replies, completions, what streams and signaling tell. They are never dropped:
one more ends the connection."""

EVENT_LIMIT: Final = 256
"""Events that may wait. One more drops the oldest waiting event; order never changes."""


class OutboxOverflow(Exception):
    """The other side does not read and its control messages no longer fit."""


def _silence(_dropped: int) -> str | None:
    """Say nothing about a gap."""
    return None


class Outbox:
    """Messages on their way out, in the order they were put, within two budgets.

    Attributes:
        gap: returns the message that stands where some events were dropped, or None for nothing.
    """

    def __init__(self, control_limit: int = CONTROL_LIMIT, event_limit: int = EVENT_LIMIT) -> None:
        self._control_limit = control_limit
        self._event_limit = event_limit
        self._entries: deque[tuple[str, bool]] = deque()
        self._events = 0
        self._ready = asyncio.Event()
        self._empty = asyncio.Event()
        self._empty.set()
        self.gap: Callable[[int], str | None] = _silence
        self._missing = 0
        self._dropped = Tally(_log, "events dropped because a reader is too slow", logging.WARNING)

    @property
    def dropped(self) -> int:
        """How many events were dropped."""
        return self._dropped.count

    def __len__(self) -> int:
        return len(self._entries)

    def put(self, text: str, *, droppable: bool = False) -> None:
        """Append one message.

        Args:
            text: the message.
            droppable: an event that may be dropped, oldest first, when too many wait.

        Raises:
            OutboxOverflow: a control message no longer fits.
        """
        if droppable:
            if self._events >= self._event_limit:
                self._drop_oldest_event()
            self._events += 1
        elif len(self._entries) - self._events >= self._control_limit:
            raise OutboxOverflow(f"{self._control_limit} control messages wait to be read")
        self._entries.append((text, droppable))
        self._ready.set()
        self._empty.clear()

    def _drop_oldest_event(self) -> None:
        oldest = next(index for index, (_, droppable) in enumerate(self._entries) if droppable)
        del self._entries[oldest]
        self._events -= 1
        self._missing += 1
        self._dropped.note()

    async def get(self) -> str:
        """Wait for the next message to send and take it."""
        while not self._entries:
            self._empty.set()
            self._ready.clear()
            await self._ready.wait()
        if self._missing and self._entries[0][1]:
            missing, self._missing = self._missing, 0
            if (notice := self.gap(missing)) is not None:
                return notice
        text, droppable = self._entries.popleft()
        self._events -= droppable
        return text

    async def drained(self) -> None:
        """Wait until the last message was taken and the taker asks for another."""
        await self._empty.wait()
