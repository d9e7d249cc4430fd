"""What waits for a conversation: words, events and ends, in a bounded queue."""

import asyncio
from collections import deque
from dataclasses import dataclass
from typing import Final, TypeAlias

from openrois_agents.mind.words import Words
from openrois_agents.tools.event_log import LoggedEvent

__all__ = ["CutShort", "Item", "News", "Over"]

_MOST: Final = 64
"""Words, events and ends that wait; the oldest words make room, and the oldest of all where there are none."""

_EVENTS: Final = frozenset(
    {"body_lost", "stopped_by_a_person", "handed_back_by_a_person", "part_taken_for_a_time", "part_came_back"}
)


@dataclass(frozen=True, slots=True)
class CutShort:
    """Speech of an answer was broken off from outside."""

    answer: int


@dataclass(frozen=True, slots=True)
class Over:
    """The conversation may be over: a goodbye was answered, or there was silence."""

    answer: int


Item: TypeAlias = Words | LoggedEvent | CutShort | Over


class News:
    """The queue; it has one reader."""

    def __init__(self) -> None:
        self._waiting: deque[Item] = deque()
        self._has_some = asyncio.Event()

    def add_words(self, words: Words) -> None:
        """Add words; those that are still being said are left out where the queue is full."""
        if words.final or len(self._waiting) < _MOST:
            self.post(words)

    def add_event(self, event: LoggedEvent) -> None:
        """Add an event, if a conversation heeds it."""
        if event.name in _EVENTS:
            self.post(event)

    def post(self, item: Item) -> None:
        """Add anything else."""
        if len(self._waiting) == _MOST:
            oldest = next((each for each in self._waiting if isinstance(each, Words)), self._waiting[0])
            self._waiting.remove(oldest)
        self._waiting.append(item)
        self._has_some.set()

    async def take_next(self) -> Item:
        """Wait for the oldest one, and take it out."""
        await self._has_some.wait()
        item = self._waiting.popleft()
        if not self._waiting:
            self._has_some.clear()
        return item
