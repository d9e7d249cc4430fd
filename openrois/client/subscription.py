"""A subscription for the application: an iterator that survives reconnects."""

import asyncio
import logging
import weakref
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import suppress
from dataclasses import dataclass
from datetime import datetime
from types import TracebackType
from typing import Generic, Self, TypeVar

from openrois.client.errors import ConnectionLost
from openrois.client.feed import BUFFER, Feed
from openrois.client.subscriptions import Entry, Subscriptions
from openrois.errors import RoISError
from openrois.jsonrpc.session import RpcError
from openrois.observability.logs import Tally
from openrois.types.messages import EventNotification

__all__ = ["Event", "Subscription"]

_log = logging.getLogger(__name__)

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class Event(Generic[T]):
    """An event with its id, type and time beside its data.

    Attributes:
        event_id: what `get_event_detail` takes.
        event_type: its name.
        expire: until when its details can be asked for, where the gateway says so.
        data: what it tells.
    """

    event_id: str
    event_type: str
    expire: datetime | None
    data: T


class Subscription(Generic[T]):
    """The events of one kind from now on, as an asynchronous iterator.

    `async for person in detection.person_detected():` subscribes at its first turn, and leaving the loop ends it.
    `async with detection.person_detected() as persons:` subscribes at once and ends at a known time.

    It survives reconnects: it is made again by itself, without the events in between. Events wait in a
    bounded buffer; the oldest makes room for the newest.
    """

    def __init__(
        self,
        table: Subscriptions,
        event_type: str,
        condition: str,
        read: Callable[[EventNotification], Awaitable[T]],
        buffer: int = BUFFER,
    ) -> None:
        self._table = table
        self._entry = Entry(event_type, condition, Feed(buffer))
        self._read = read
        self._opening = asyncio.Lock()
        self._open = False
        self._closed = False
        self._unreadable = Tally(_log, f"{event_type} events that cannot be read", logging.WARNING)

    def __repr__(self) -> str:
        return f"<Subscription to {self._entry.event_type} where {self._entry.condition or 'anything'}>"

    @property
    def dropped(self) -> int:
        """Number of events that were dropped because the reader was too slow."""
        return self._entry.feed.dropped

    @property
    def unreadable(self) -> int:
        """Number of events left out: they do not fit their type, or their details were not available any more."""
        return self._unreadable.count

    @property
    def interruptions(self) -> int:
        """Number of times it ended and had to be made again: events may be missing as often."""
        return self._entry.interruptions

    @property
    def active(self) -> bool:
        """Whether the gateway has the subscription now."""
        return bool(self._entry.subscribe_id)

    async def __aenter__(self) -> Self:
        if self._closed:
            raise RuntimeError("this subscription was closed: subscribe again")
        await self._ensure_open()
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        await self.close()

    async def close(self) -> None:
        """Unsubscribe; events that came before can still be read."""
        self._closed = True
        self._entry.feed.end_feed()
        await self._table.close(self._entry)

    def __aiter__(self) -> Self:
        return self

    async def __anext__(self) -> T:
        return (await self._next()).data

    async def events(self) -> AsyncIterator[Event[T]]:
        """Iterate over the events with their ids and times, not their data alone."""
        with suppress(StopAsyncIteration):
            while True:
                yield await self._next()

    async def _ensure_open(self) -> None:
        async with self._opening:
            if self._open or self._closed:
                return
            await self._table.open(self._entry)
            self._open = True
            loop = asyncio.get_running_loop()
            weakref.finalize(self, _unread, loop, self._table, self._entry).atexit = False

    async def _next(self) -> Event[T]:
        """Return the next event that can be read."""
        await self._ensure_open()
        while True:
            notification = await anext(self._entry.feed)
            try:
                data = await self._read(notification)
            except (ValueError, RoISError, RpcError, ConnectionLost, TimeoutError) as error:
                self._unreadable.note(str(error))
                continue
            return Event(notification.event_id, notification.event_type, _date_time(notification.expire), data)


def _unread(loop: asyncio.AbstractEventLoop, table: Subscriptions, entry: Entry) -> None:
    """Drop a subscription whose iterator was collected; that may happen in any thread, and after the loop's end."""
    with suppress(RuntimeError):
        loop.call_soon_threadsafe(table.abandon, entry)


def _date_time(text: str) -> datetime | None:
    try:
        return datetime.fromisoformat(text)
    except ValueError:
        return None
