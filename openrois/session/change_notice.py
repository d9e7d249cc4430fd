"""Telling an application that something has changed: some changes at once, of a flood one a second, and the last."""

import asyncio
import time
from collections.abc import Callable
from typing import Final

from openrois.aio.rate import RateLimit

__all__ = ["ChangeNotice"]

CHANGES_AT_ONCE: Final = 10
"""Changes that are told in a burst, each as it comes: a fleet that starts, somebody who works at an adapter."""

CHANGES_PER_SECOND: Final = 1
"""Changes that are told in the long run: whoever hears of one asks for everything again."""


class ChangeNotice:
    """The notice of changes, which says nothing but that there was one: what comes while one is due is told with it.

    Args:
        tell: tells the application; must not block.
        clock: monotonic seconds.
    """

    def __init__(self, tell: Callable[[], None], clock: Callable[[], float] = time.monotonic) -> None:
        self._tell = tell
        self._limit = RateLimit(CHANGES_AT_ONCE, CHANGES_PER_SECOND, clock)
        self._due: asyncio.TimerHandle | None = None

    def changed(self) -> None:
        """Tell of a change, now or as soon as one more may be told."""
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
        """Tell nothing any more."""
        if self._due is not None:
            self._due.cancel()
