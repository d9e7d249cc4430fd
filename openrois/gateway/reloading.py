"""Reads files again when they change, or on demand."""

import asyncio
import logging
from collections.abc import Awaitable, Callable, Iterable
from pathlib import Path
from typing import Final

__all__ = ["Reloader"]

_log = logging.getLogger(__name__)

LOOK_INTERVAL: Final = 0.5
"""Seconds between two checks."""

_State = tuple[tuple[int, int, int], ...]


class Reloader:
    """Watches files. Content that cannot be used is logged, and the previous one stays in use."""

    def __init__(self, sleep: Callable[[float], Awaitable[None]] = asyncio.sleep) -> None:
        self._sleep = sleep
        self._watched: list[tuple[tuple[Path, ...], Callable[[], None], str]] = []
        self._states: list[_State] = []
        self.failures = 0

    def add(self, paths: Iterable[Path], reload: Callable[[], None], what: str) -> None:
        """Watch files from now on.

        Args:
            paths: the files.
            reload: reads them; raises where it cannot use them, a `ValueError` with a sentence if it knows why.
            what: what is in them, for the log.
        """
        watched = tuple(paths)
        self._watched.append((watched, reload, what))
        self._states.append(_state(watched))

    async def run(self) -> None:
        """Check for ever."""
        while True:
            await self._sleep(LOOK_INTERVAL)
            self.reload_changed()

    def reload_changed(self, *, at_all: bool = False) -> None:
        """Read again what has changed, or everything."""
        for place, (paths, reload, what) in enumerate(self._watched):
            state = _state(paths)
            if not at_all and state == self._states[place]:
                continue
            self._states[place] = state
            try:
                reload()
                _log.info("%s: read again", what)
            except Exception as error:
                # Any error, such as a file that goes while it is read: the other files have to be watched on.
                self.failures += 1
                _log.error("%s: the previous content stays in use: %s", what, error)


def _state(paths: Iterable[Path]) -> _State:
    return tuple(_one(path) for path in paths)


def _one(path: Path) -> tuple[int, int, int]:
    try:
        found = path.stat()
    except OSError:
        return (0, 0, 0)
    return (found.st_mtime_ns, found.st_size, found.st_ino)
