"""A reply before the notifications that its call causes, where both come from an engine behind this one. Pure.

There they arrive in the right order and then go different ways: the reply through the call that waits for it, a
notification straight to the application. So notifications are held back until the reply has left.
"""

from collections import deque
from collections.abc import Callable, Hashable
from dataclasses import dataclass, field
from typing import Final

__all__ = ["ReplyFirst"]

MAX_HELD: Final = 256
"""Notifications of one lane that are held back; of more the oldest leaves without waiting any longer."""


@dataclass(slots=True)
class _Lane:
    """Calls without a reply by number, and held notifications, each with the last call made before it."""

    calls: set[int] = field(default_factory=set)
    last: int = 0
    held: deque[tuple[int, Callable[[], None]]] = field(default_factory=deque)

    def release(self) -> None:
        while self.held and (len(self.held) > MAX_HELD or not any(call <= self.held[0][0] for call in self.calls)):
            self.held.popleft()[1]()


class ReplyFirst:
    """Holds notifications back while a call that may have caused them has no reply yet.

    Each lane, which stands for one application and one engine, is on its own: a slow engine delays only itself.
    """

    def __init__(self) -> None:
        self._lanes: dict[Hashable, _Lane] = {}

    def asked(self, lane: Hashable) -> Callable[[], None]:
        """Note a call and return a function to call, once or more, when its reply has left."""
        entry = self._lanes.setdefault(lane, _Lane())
        entry.last += 1
        call = entry.last
        entry.calls.add(call)

        def replied() -> None:
            entry.calls.discard(call)
            entry.release()
            if not entry.calls and self._lanes.get(lane) is entry:
                del self._lanes[lane]

        return replied

    def notify_after_replies(self, lane: Hashable, notify: Callable[[], None]) -> None:
        """Call `notify` as soon as every call that came before it has its reply."""
        entry = self._lanes.get(lane)
        if entry is None:
            notify()
        else:
            entry.held.append((entry.last, notify))
            entry.release()

    def clear(self) -> None:
        """Drop what is held."""
        for entry in self._lanes.values():
            entry.held.clear()
        self._lanes.clear()
