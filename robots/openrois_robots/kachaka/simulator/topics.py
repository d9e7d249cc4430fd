"""Topics with cursors of one clock, as the vendor's client expects them. Pure.

A cursor is a moment. A request with the cursor 0 is answered with the present state, one with another cursor when the
topic has changed after that moment: the client waits for a result with the cursor that it got with a state.
"""

from collections.abc import Iterable
from typing import Final

__all__ = ["Topics"]

_MICROSECONDS: Final = 1e6


class Topics:
    """Topics, and the cursor of the last change of each.

    Args:
        names: of the topics.
        now: seconds of the clock.
    """

    def __init__(self, names: Iterable[str], now: float) -> None:
        self._last = int(now * _MICROSECONDS)
        self._cursors = dict.fromkeys(names, self._last)

    def note_change(self, topic: str, now: float) -> None:
        """Note that a topic has changed; no two changes have one cursor."""
        self._last = max(self._last + 1, int(now * _MICROSECONDS))
        self._cursors[topic] = self._last

    def cursor(self, topic: str) -> int:
        """Return the cursor of the last change."""
        return self._cursors[topic]

    def is_news(self, topic: str, cursor: int) -> bool:
        """Tell whether a request with this cursor is answered now."""
        return cursor == 0 or self._cursors[topic] > cursor
