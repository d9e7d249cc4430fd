"""The event log of a caller: what happened around its body, numbered, bounded, and waited for."""

import asyncio
from collections import deque
from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass, field
from datetime import UTC, datetime
from typing import Any, Final, Protocol

from openrois.aio.listeners import Listeners

__all__ = ["EventLog", "Guard", "LoggedEvent", "tellable"]

MAX_EVENTS: Final = 256
"""Events that a log keeps; the oldest makes room for the newest."""


class Guard(Protocol):
    """Asks persons whether what tells of them may be told."""

    async def ask(self) -> Callable[[Mapping[str, Any]], bool]:
        """Ask now; return what says so of the data of events."""
        ...


@dataclass(frozen=True, slots=True)
class LoggedEvent:
    """An event in the log.

    Attributes:
        number: of the event; each next one is greater by one.
        at: when it came, as RFC 3339 has it.
        name: its type.
        source: the component that announced it; the body, where it is about control.
        data: what it tells.
        guard: asks whether it may be told; None where it may in any case.
    """

    number: int
    at: str
    name: str
    source: str
    data: dict[str, Any]
    guard: "Guard | None" = field(default=None, compare=False, repr=False)

    def as_json(self) -> dict[str, Any]:
        """Return it as an object of JSON."""
        return {"number": self.number, "at": self.at, "event": self.name, "source": self.source, "data": self.data}


class EventLog:
    """Keeps the last `MAX_EVENTS` events.

    Args:
        now: the time of day.
    """

    def __init__(self, now: Callable[[], datetime] = lambda: datetime.now(UTC)) -> None:
        self._now = now
        self._events: deque[LoggedEvent] = deque(maxlen=MAX_EVENTS)
        self._last = 0
        self.added: Listeners[LoggedEvent] = Listeners()

    @property
    def last(self) -> int:
        """The number of the newest event; 0 before the first."""
        return self._last

    def add(self, name: str, source: str, data: dict[str, Any], guard: Guard | None = None) -> None:
        """Add an event, and tell those who wait for it."""
        self._last += 1
        event = LoggedEvent(self._last, self._now().isoformat(timespec="milliseconds"), name, source, data, guard)
        self._events.append(event)
        self.added.notify_all(event)

    def after(self, number: int, names: Collection[str] = ()) -> list[LoggedEvent]:
        """Return the events behind a number, all or those with one of these names."""
        return [each for each in self._events if each.number > number and (not names or each.name in names)]

    async def wait(self, number: int, names: Collection[str], seconds: float) -> list[LoggedEvent]:
        """Return the events behind a number as soon as there is one; none when the seconds are over."""
        news = asyncio.Event()
        remove = self.added.add(lambda _event: news.set())
        try:
            async with asyncio.timeout(seconds):
                while not (found := self.after(number, names)):
                    news.clear()
                    await news.wait()
                return found
        except TimeoutError:
            return self.after(number, names)
        finally:
            remove()


async def tellable(events: Iterable[LoggedEvent]) -> list[LoggedEvent]:
    """Return the events that may be told now: consent may have ended since they came. Each guard is asked once."""
    events = list(events)
    guards = {id(each.guard): each.guard for each in events if each.guard is not None}
    allows = {key: await guard.ask() for key, guard in guards.items()}
    return [each for each in events if each.guard is None or allows[id(each.guard)](each.data)]
