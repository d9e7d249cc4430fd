"""Notifications that the profile has changed: some at once, under a flood one a second, and always the last."""

import asyncio
import time
from collections.abc import Callable
from typing import Final

from openrois.aio.rate import RateLimit

__all__ = ["ChangeNotice"]

CHANGES_AT_ONCE: Final = 10
"""Changes that are notified in a burst, each as it comes: a fleet that starts, an author at work on an adapter."""

CHANGES_PER_SECOND: Final = 1
"""Changes that are notified in the long run: an application reads everything again after each."""


class ChangeNotice:
    """The notification of changes, which has no content: changes while one is due share it.

    Args:
        tell: tells the application; must not block.
        clock: monotonic seconds.
    """

    def __init__(self, tell: Callable[[], None], clock: Callable[[], float] = time.monotonic) -> None:
        self._tell = tell
        self._limit = RateLimit(CHANGES_AT_ONCE, CHANGES_PER_SECOND, clock)
        self._due: asyncio.TimerHandle | None = None

    def changed(self) -> None:
        """Notify a change, now or as soon as one more may be sent."""
        if self._due is not None:
            return
        if self._limit.admits():
            self._tell()
        else:
            self._due = asyncio.get_running_loop().call_later(self._limit.wait(), self._look_again)

    def _look_again(self) -> None:
        self._due = None
        self.changed()

    def close(self) -> None:
        """Notify nothing any more."""
        if self._due is not None:
            self._due.cancel()
