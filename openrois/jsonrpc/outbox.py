"""The bounded, ordered outbox of one connection."""

import asyncio
import logging
from collections.abc import Callable
from typing import Final

from openrois.aio.lean_event import LeanEvent
from openrois.aio.lean_queue import LeanQueue
from openrois.jsonrpc.unread import UnreadAccount, UnreadBudget
from openrois.observability.logs import Tally

__all__ = ["Outbox", "OutboxOverflow"]

_log = logging.getLogger(__name__)

CONTROL_LIMIT: Final = 4096
"""Messages that may wait, events aside: replies, completions, notifications of streams. They are never dropped:
one more ends the connection."""

CONTROL_TEXT: Final = 16 * 1024 * 1024
"""Characters of them all: a profile is long enough for a few to fill a memory. One alone may be longer."""

EVENT_LIMIT: Final = 256
"""Events that may wait. One more drops the oldest waiting event; order never changes."""

EVENT_TEXT: Final = 4 * 1024 * 1024
"""Characters of them all."""


class OutboxOverflow(Exception):
    """The other side does not read and its control messages no longer fit."""


def _silence(_dropped: int) -> str | None:
    """Return no message for a gap."""
    return None


class _Lane:
    """Messages of one kind that wait, each with its number in the order of all."""

    __slots__ = ("_most", "_most_text", "_text", "entries")

    def __init__(self, most: int, most_text: int) -> None:
        self.entries = LeanQueue[tuple[int, str]]()
        self._most = most
        self._most_text = most_text
        self._text = 0

    def has_room_for(self, text: str) -> bool:
        return not self.entries or (len(self.entries) < self._most and self._text + len(text) <= self._most_text)

    def clear(self) -> None:
        self.entries.clear()
        self._text = 0

    def is_half_empty(self) -> bool:
        return len(self.entries) * 2 < self._most and self._text * 2 < self._most_text

    def put(self, number: int, text: str) -> None:
        self.entries.put((number, text))
        self._text += len(text)

    def pop_text(self) -> str:
        _, text = self.entries.pop()
        self._text -= len(text)
        return text


class Outbox:
    """Messages on their way out, in the order they were put, within two budgets.

    Attributes:
        gap: returns the message that stands where some events were dropped, or None for nothing.
        account: counts the characters that wait here, and those that were taken and are being sent.
    """

    def __init__(self, control_limit: int = CONTROL_LIMIT, event_limit: int = EVENT_LIMIT) -> None:
        self._control = _Lane(control_limit, CONTROL_TEXT)
        self._events = _Lane(event_limit, EVENT_TEXT)
        self._put = 0
        self._ready = LeanEvent()
        self._empty = LeanEvent()
        self._empty.set()
        self._roomy = LeanEvent()
        self._asking = 0
        self._asking_in_turn = asyncio.Lock()
        self._closed = False
        self.gap: Callable[[int], str | None] = _silence
        self.account = UnreadAccount(UnreadBudget(), "", self.close)
        self._taken = 0
        self._missing = 0
        self._dropped = Tally(_log, "events dropped because a reader is too slow", logging.WARNING)

    @property
    def dropped(self) -> int:
        """Number of events that were dropped."""
        return self._dropped.count

    @property
    def is_roomy(self) -> bool:
        """Whether less than half of what may wait does, events aside."""
        return self._control.is_half_empty()

    def __len__(self) -> int:
        return len(self._control.entries) + len(self._events.entries)

    def put(self, text: str, *, droppable: bool = False) -> None:
        """Append one message.

        Args:
            text: the message.
            droppable: an event that may be dropped, oldest first, when too many wait.

        Raises:
            OutboxOverflow: a control message no longer fits, or nothing does: others need the room more.
        """
        lane = self._events if droppable else self._control
        while not lane.has_room_for(text):
            if not droppable:
                raise OutboxOverflow(f"{len(lane.entries)} control messages wait: the other side does not read")
            self.account.remove(len(lane.pop_text()))
            self._missing += 1
            self._dropped.note()
        self._put += 1
        lane.put(self._put, text)
        self._ready.set()
        self._empty.clear()
        self.account.add(len(text))
        if not self.account.is_open:
            raise OutboxOverflow("too much waits unread on all connections, and most of it on this one")

    async def get(self) -> str:
        """Wait for the next message to send and take it; what was taken before has been sent."""
        await self._something()
        return self._pop_text()

    async def get_some(self, most_text: int) -> list[str]:
        """Wait for the next message to send and take it with all that wait behind it, up to `most_text` characters.

        What was taken before has been sent.
        """
        await self._something()
        texts = [self._pop_text()]
        room = most_text - len(texts[0])
        while room > 0 and len(self):
            text = self._pop_text()
            texts.append(text)
            room -= len(text)
        return texts

    async def _something(self) -> None:
        self.account.remove(self._taken)
        self._taken = 0
        while not len(self):
            self._empty.set()
            self._ready.clear()
            await self._ready.wait()

    def _pop_text(self) -> str:
        control, event = self._control.entries.first(), self._events.entries.first()
        if event is None or (control is not None and control < event):
            text = self._control.pop_text()
            self._taken += len(text)
            if self._control.is_half_empty():
                self._roomy.set()
            return text
        if self._missing:
            missing, self._missing = self._missing, 0
            if (notice := self.gap(missing)) is not None:
                return notice
        text = self._events.pop_text()
        self._taken += len(text)
        return text

    async def room(self) -> bool:
        """Wait until a request may be sent: half of what may wait is kept for messages that cannot be put off.

        Callers get room in the order in which they came. Returns whether there is room: closed, there is none any more.
        """
        if self.is_roomy and not self._asking:
            return not self._closed
        self._asking += 1
        try:
            async with self._asking_in_turn:
                while not self._closed and not self.is_roomy:
                    self._roomy.clear()
                    await self._roomy.wait()
        finally:
            self._asking -= 1
        return not self._closed

    def close(self) -> None:
        """Drop what waits, and release every caller that waits for room: nothing more will be sent."""
        self._closed = True
        self._control.clear()
        self._events.clear()
        self._roomy.set()

    async def drained(self) -> None:
        """Wait until the last message was taken and the sender asks for another."""
        await self._empty.wait()
