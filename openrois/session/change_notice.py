"""Notifications that the directory has changed: some at once, under a flood one a second, and always the last."""

import asyncio
import time
from collections.abc import Callable, Iterable, Mapping
from typing import Any, Final

from openrois.aio.rate import RateLimit
from openrois.types.directory import MAX_CHANGED, DirectoryChangedNotification

__all__ = ["ChangeNotice"]

CHANGES_AT_ONCE: Final = 10
"""Changes that are notified in a burst, each as it comes: a fleet that starts, an author at work on an adapter."""

CHANGES_PER_SECOND: Final = 1
"""Changes that are notified in the long run: an application may read everything again after each."""

_PROFILE_CHANGED: Final = "rois.system.profile_changed"


class ChangeNotice:
    """The notification of changes; changes while one is due share it.

    An application of the base wire learns that something has changed. One that speaks `openrois.directory` learns of
    which engines, and that without names where they are too many.

    Args:
        notify: sends a notification; must not block.
        has_engine: tells whether an engine is there now.
        clock: monotonic seconds.
    """

    def __init__(
        self,
        notify: Callable[[str, Mapping[str, Any]], None],
        has_engine: Callable[[str], bool],
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._notify = notify
        self._has_engine = has_engine
        self._limit = RateLimit(CHANGES_AT_ONCE, CHANGES_PER_SECOND, clock)
        self._due: asyncio.TimerHandle | None = None
        self._is_naming = False
        self._named: dict[str, None] = {}
        self._unnamed = 0

    def name_engines(self) -> None:
        """Name the engines from now on."""
        self._is_naming = True

    def changed(self, engine_ids: Iterable[str]) -> None:
        """Notify a change of engines, now or as soon as one more may be sent."""
        if self._is_naming:
            self._note(engine_ids)
        if self._due is None:
            self._tell_or_wait()

    def flush(self) -> None:
        """Notify at once what waits: the application asks for the directory as it is now."""
        if self._due is not None:
            self._due.cancel()
            self._due = None
            self._tell()

    def _note(self, engine_ids: Iterable[str]) -> None:
        for engine_id in engine_ids:
            if len(self._named) >= MAX_CHANGED and engine_id not in self._named:
                self._unnamed += 1
            else:
                self._named[engine_id] = None

    def _tell_or_wait(self) -> None:
        self._due = None
        if self._limit.admits():
            self._tell()
        else:
            self._due = asyncio.get_running_loop().call_later(self._limit.wait(), self._tell_or_wait)

    def _tell(self) -> None:
        if not self._is_naming:
            self._notify(_PROFILE_CHANGED, {})
            return
        there = {engine_id: self._has_engine(engine_id) for engine_id in self._named}
        told = DirectoryChangedNotification(
            changed=tuple(sorted(engine_id for engine_id, is_there in there.items() if is_there)),
            gone=tuple(sorted(engine_id for engine_id, is_there in there.items() if not is_there)),
            unnamed=self._unnamed,
        )
        self._named, self._unnamed = {}, 0
        self._notify(told.method, told.model_dump(mode="json"))

    def close(self) -> None:
        """Notify nothing any more."""
        if self._due is not None:
            self._due.cancel()
